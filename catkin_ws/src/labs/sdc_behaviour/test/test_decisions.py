"""What the student writes: predictions, gaps, the safe distance, monitors."""

import math

import numpy as np
import pytest

from sdc_behaviour.driver import LaneRoad
from sdc_behaviour.gaps import OnLane
from sdc_behaviour.junction import may_enter, time_in_space
from sdc_behaviour.lanes import predicted
from sdc_behaviour.manoeuvre import LaneProposal, LaneScene, choose, simulate
from sdc_behaviour.monitor import always, eventually, keeps_distance
from sdc_behaviour.roads import ROAD, SIDE_M, crossing_road
from sdc_behaviour.rss import Rss, following_mps2, safe_distance_m
from sdc_common.driving import DetectedObstacle

WORST = Rss(0.5, 2.0, 4.0, 8.0)


def car(x_m, y_m, yaw_rad, speed_mps):
    return DetectedObstacle(x_m, y_m, yaw_rad, 4.7, 2.0, speed_mps)


def test_road_user_follows_its_lanes_across_the_junction_beside_their_middle():
    points = predicted(crossing_road(), car(290.0, 0.4, 0.0, 10.0), np.array([0.0, 1.0, 3.0]))
    assert points == pytest.approx(np.array([(290.0, 0.4), (300.0, 0.4), (320.0, 0.4)]))


def test_pedestrian_who_crosses_the_lane_is_predicted_straight_ahead():
    points = predicted(crossing_road(), car(100.0, -1.0, math.pi / 2, 1.5), np.array([2.0]))
    assert points == pytest.approx(np.array([(100.0, 2.0)]))


def closest_m(gap_m, rear_mps, front_mps, rss):
    """Return the least distance in the worst case, by small steps of time."""
    step_s, time_s, least_m = 0.001, 0.0, gap_m
    while rear_mps > 0.0 or time_s < rss.response_s:
        reacts = time_s < rss.response_s
        a = rss.accelerating_mps2 if reacts else -rss.own_braking_mps2
        rear, front = (
            max(rear_mps + a * step_s, 0.0),
            max(front_mps - rss.other_braking_mps2 * step_s, 0.0),
        )
        gap_m += 0.5 * step_s * (front + front_mps - rear - rear_mps)
        rear_mps, front_mps, time_s = rear, front, time_s + step_s
        least_m = min(least_m, gap_m)
    return least_m


@pytest.mark.parametrize(("rear_mps", "front_mps"), [(10.0, 8.0), (14.0, 14.0), (20.0, 0.0)])
def test_safe_distance_is_used_up_in_the_worst_case(rear_mps, front_mps):
    distance_m = safe_distance_m(rear_mps, front_mps, WORST)
    assert closest_m(distance_m, rear_mps, front_mps, WORST) == pytest.approx(0.0, abs=0.05)


def test_car_at_the_safe_distance_neither_accelerates_nor_brakes_hard():
    distance_m = safe_distance_m(12.0, 12.0, Rss())
    assert -1.0 < following_mps2(12.0, distance_m + 2.0, 12.0, 14.0, Rss()) < 0.0
    assert following_mps2(12.0, 0.4 * distance_m, 12.0, 14.0, Rss()) < -5.0


def test_road_user_is_on_the_lane_that_it_drives_along():
    road = LaneRoad(crossing_road(), ROAD)
    assert road.on_lane(car(80.0, 3.2, 0.0, 9.0), 60.0) == OnLane(80.0, 9.0, 4.7, 1)
    assert road.on_lane(car(SIDE_M, 2.0, -math.pi / 2, 9.0), 290.0) is None


def test_gap_is_accepted_only_with_its_margin_on_both_sides():
    times_s = np.arange(0.0, 10.0, 0.5)
    points_m = np.column_stack([-20.0 + 4.0 * times_s, np.zeros(20)])
    assert time_in_space(points_m, times_s, np.zeros(2), 5.0) == (4.0, 6.0)
    assert not may_enter((2.0, 3.5), [(4.0, 6.0)], 1.0)
    assert may_enter((1.0, 3.0), [(4.0, 6.0)], 1.0) and may_enter((7.0, 9.0), [(4.0, 6.0)], 1.0)


def test_change_before_a_fast_one_breaks_a_rule_that_politeness_sets():
    others = OnLane(85.0, 5.0, 12.0), OnLane(28.0, 13.0, 4.7, 1)
    rude, polite = (
        simulate(LaneScene(OnLane(50.0, 10.0), others, politeness=one), LaneProposal(1, 14.0))
        for one in (0.5, 3.0)
    )
    assert not rude.breaks_rule and polite.breaks_rule


def test_car_that_may_not_pass_a_line_stays_before_it():
    scene = LaneScene(OnLane(250.0, 12.0), stop_m=300.0)
    outcome = simulate(scene, choose(scene))
    assert not outcome.breaks_rule and outcome.accelerations_mps2.min() > -4.05


def test_monitors_have_the_sign_and_the_margin_of_their_rule():
    signal = np.array([3.0, -1.0, 2.0])
    assert always(signal, 1).tolist() == [-1.0, -1.0, 2.0]
    assert eventually(signal, 1).tolist() == [3.0, 2.0, 2.0]
    assert keeps_distance(np.array([math.inf, 30.0, 25.0]), np.array([9.0, 10.0, 10.0])) == 5.0
