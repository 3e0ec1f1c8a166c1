"""Missions over lanes: their points and limits, and when another one is planned."""

import numpy as np
import pytest

from sdc_map.global_planner import GlobalPlanner
from sdc_map.lane_graph import NoRouteError
from sdc_map.network import Network, RoadLane


def lane(name, points, limit_mps=10.0, leads=(), left="", right=""):
    points = np.array(points, float)
    return RoadLane(name, points, 3.5, limit_mps, successors=leads, left=left, right=right)


# Two lanes to the east, of which the left one turns left and the right one goes on.
_FORK = Network(
    "fork",
    [
        lane("right", [(0, 0), (200, 0)], 12.0, ("on",), left="left"),
        lane("left", [(0, 3.5), (200, 3.5)], 12.0, ("turn",), right="right"),
        lane("on", [(200, 0), (400, 0)], 8.0),
        lane("turn", [(200, 3.5), (210, 6.5), (214, 15), (214, 200)], 6.0),
    ],
)
_GOAL_ON, _GOAL_TURN = (350.0, 1.0), (214.0, 150.0)


def test_mission_changes_lanes_smoothly_and_has_their_limits():
    mission = GlobalPlanner(_FORK, [_GOAL_TURN]).update(20.0, 0.5, 0.0)
    assert mission.lanes == ("right", "left", "turn")
    steps = np.diff(mission.points_m, axis=0)
    assert np.hypot(*steps.T) == pytest.approx(np.ones(len(steps)), abs=0.1)
    straight = mission.points_m[:-1, 0] < 190.0
    assert np.abs(np.degrees(np.arctan2(steps[straight, 1], steps[straight, 0]))).max() < 10.0
    assert mission.points_m[0] == pytest.approx([20.0, 0.0])
    assert mission.points_m[-1] == pytest.approx([214.0, 150.0])
    assert set(mission.limits_mps) == {12.0, 6.0}


def test_limit_of_a_straight_lane_begins_where_the_lane_begins():
    mission = GlobalPlanner(_FORK, [_GOAL_ON]).update(20.0, 0.0, 0.0)
    east = mission.points_m[:, 0]
    assert mission.limits_mps[east < 199.0] == pytest.approx(12.0)
    assert mission.limits_mps[east > 201.0] == pytest.approx(8.0)


def test_mission_leads_over_all_goals():
    planner = GlobalPlanner(_FORK, [(50.0, 0.0), _GOAL_ON])
    mission = planner.update(10.0, 0.0, 0.0)
    assert mission.ends_m == pytest.approx((40.0, 340.0))
    for x in range(10, 70):
        assert planner.update(float(x), 0.0, 0.0) is None
    assert planner.goals == [_GOAL_ON]


def test_new_goal_and_closed_lane_give_another_mission():
    planner = GlobalPlanner(_FORK, [_GOAL_ON])
    assert planner.update(10.0, 0.0, 0.0).lanes[-1] == "on"
    planner.drive_to([_GOAL_TURN])
    assert planner.update(20.0, 0.0, 0.0).lanes[-1] == "turn"
    planner.close("on")
    assert planner.update(21.0, 0.0, 0.0) is None
    planner.close("turn")
    assert planner.update(22.0, 0.0, 0.0) is None and "past the closed lanes" in planner.problem
    assert planner.update(23.0, 0.0, 0.0) is None and planner.problem == ""
    assert planner.mission.lanes[-1] == "turn"
    with pytest.raises(ValueError, match="no lane 'up'"):
        planner.close("up")


def test_wrong_turn_gives_another_mission():
    back = [
        lane("on", [(200, 0), (400, 0)], leads=("back",)),
        _FORK.lanes["turn"],
        lane("back", [(400, 0), (405, 8), (400, 16), (200, 3.5)], leads=("turn",)),
    ]
    planner = GlobalPlanner(
        Network("loop", [*list(_FORK.lanes.values())[:2], *back]), [(214.0, 190.0)]
    )
    assert planner.update(10.0, 3.5, 0.0).lanes == ("left", "turn")
    # The car goes straight on.
    found = [planner.update(float(x), 3.5 if x < 200 else 0.0, 0.0) for x in range(11, 230)]
    (mission,) = [one for one in found if one is not None]
    assert mission.lanes == ("on", "back", "turn")


@pytest.mark.parametrize(
    ("goal", "words"),
    [((0.0, 90.0), "is on no lane"), ((10.0, 0.0), r"goal \(10.0, 0.0\) cannot be reached")],
)
def test_goal_that_cannot_be_reached_is_one_line(goal, words):
    with pytest.raises(NoRouteError, match=words) as error:
        GlobalPlanner(_FORK, [goal]).update(100.0, 0.0, 0.0)
    assert "\n" not in str(error.value)


def test_car_that_is_on_no_lane_gets_no_mission():
    with pytest.raises(NoRouteError, match="no lane is within 20 m"):
        GlobalPlanner(_FORK, [_GOAL_ON]).update(100.0, -50.0, 0.0)
