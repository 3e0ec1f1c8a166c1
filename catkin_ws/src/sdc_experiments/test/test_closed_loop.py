"""Drives in one process: their report, their arguments, and their errors.

test_scenarios.py compares them with the drives of real nodes.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from sdc_behaviour.driver import BehaviourDriver, LaneRoad
from sdc_behaviour.roads import ROAD, crossing_road
from sdc_common.geometry import road_line, segments
from sdc_experiments.closed_loop import drive, drive_result, evaluation_rules
from sdc_experiments.configuration import node_parameters
from sdc_experiments.recorder import DriveRecorder
from sdc_package.local_planner import OffRouteError
from sdc_package.steering.stanley import StanleySteering
from sdc_sim.physics.obstacles import CollisionEvent, ObstacleState
from sdc_sim.scenario.drive_setup import drive_setup

pytestmark = pytest.mark.slow(7)

STRAIGHT = [{"straight_m": 40.0}]


def test_equal_arguments_give_equal_traces():
    options = {"odometry_noise": {"position_m": 0.05}, "friction": 0.8}
    first, second, other = (
        drive_result(route=STRAIGHT, seed=seed, sim_options=options).rows for seed in (3, 3, 4)
    )
    assert np.array_equal(first, second, equal_nan=True)
    assert not np.array_equal(first[:50], other[:50], equal_nan=True)


def test_drive_in_machine_code_has_the_numbers_of_a_plain_one(monkeypatch):
    pytest.importorskip("numba")
    monkeypatch.setattr(segments, "_in_machine_code", False)
    bend = [{"straight_m": 8.0}, {"left_deg": 200.0, "radius_m": 8.0, "transition_m": 4.0}]
    options = {"odometry_noise": {"position_m": 0.05}, "side_wind_mps": 8.0}
    results = []
    for compiled in (False, True):
        road_line._route.cache_clear()  # its lines would stay plain
        results.append(drive_result(route=bend, seed=3, sim_options=options, compiled=compiled))
        assert results[-1].progress.route.line.numbers.are_arrays == compiled
    plain, compiled = results
    assert plain.metrics == compiled.metrics
    assert len(plain.rows) > 100
    assert np.array_equal(plain.rows, compiled.rows)


def test_car_without_brakes_for_a_parked_one_collides():
    def blind(observation):
        return [(observation.x_m + ahead, 0.0, 5.0) for ahead in (1.0, 2.0, 30.0)]

    seen = drive("stopped_car", longest_s=14.0)
    assert seen["infractions"]["collision_vehicle"] == 0
    report = drive("stopped_car", planner=blind)
    assert report["status"] == "collision"
    assert report["infractions"]["collision_vehicle"] == 1


def test_steering_is_a_name_an_object_or_a_function():
    beside = {"route": STRAIGHT, "sim_options": {"start": {"left_m": 0.5}}}
    textbook, options = drive(steering="stanley", **beside), {"steering_method": "stanley"}
    assert textbook == drive(controller_options=options, **beside)
    method = StanleySteering.__new__(StanleySteering)

    def left(path, x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps):
        return 0.3

    method.wheel_angle = left
    for steering in (left, method):
        assert drive(route=STRAIGHT, steering=steering)["status"] == "off_route"


def test_section_of_an_own_steering_method_is_passed_to_it(monkeypatch, tmp_path):
    (tmp_path / "my_closed_loop_module.py").write_text(
        "class Constant:\n"
        "    def __init__(self, axles, angle_rad):\n"
        "        self.angle_rad = angle_rad\n"
        "    def wheel_angle(self, *pose):\n"
        "        return self.angle_rad\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    options = {"controller_options": {"Constant": {"angle_rad": 0.05}}, "longest_s": 6.0}
    result = drive_result(route=STRAIGHT, steering="my_closed_loop_module:Constant", **options)
    assert result.progress.samples[-1].y_m > 0.1
    assert result.metrics["status"] == "aborted"


def test_driver_of_the_behaviour_lab_is_a_planner():
    planner = BehaviourDriver(LaneRoad(crossing_road(), ROAD), limit_mps=10.0)
    points = np.column_stack([np.arange(0.0, 200.0), np.zeros(200)])
    result = drive_result(route=points, planner=planner.plan, longest_s=25.0)
    assert result.metrics["cross_track_max_m"] < 0.2
    assert result.metrics["route_completion_percent"] > 60.0
    assert sum(result.metrics["infractions"].values()) == 0


def test_controller_brakes_when_the_planner_has_no_path():
    def planner(observation):
        if observation.stamp_s >= 4.0:
            raise OffRouteError("no path")
        return [(observation.x_m + ahead, 0.0, 8.0) for ahead in (1.0, 2.0, 30.0)]

    result = drive_result(route=[{"straight_m": 200.0}], planner=planner, longest_s=9.0)
    speeds = result.progress.column("speed_mps")
    assert speeds.max() > 3.0
    assert speeds[-1] == 0.0
    assert result.reasons[-1] == "path_timeout"
    assert result.metrics["missed_ticks"] > 50


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scenario": "slalon"}, "unknown scenario 'slalon'; did you mean 'slalom'?"),
        ({"sim_options": {"frction": 1.0}}, "sim_options: unknown parameter 'frction'; did you"),
        ({"sim_options": {"friction": -1.0}}, "friction must be"),
        ({"planner_options": {"lookahead": 3}}, "planner_options: unknown parameter 'lookahead'"),
        ({"controller_options": {"pid": {"k": 3}}}, "controller_options, section 'pid': unknown"),
        ({"referee_options": {"blocked": 3}}, "referee_options: unknown parameter 'blocked'"),
        ({"steering": "stanly"}, "there is no steering_method 'stanly': did you mean 'stanley'"),
        ({"steering": 3}, "steering: must be a name, an object with a method wheel_angle or"),
        ({"route": [1, 2]}, "route: must be"),
        ({"route": np.zeros((3, 2))}, "coincide"),
        ({"route": np.array([[6e6, 0.0], [6e6, 9.0]])}, "route: a coordinate is beyond 100 km"),
        ({"route": "missing.csv"}, "missing.csv: the file cannot be read"),
        ({"sim_options": {"vehicle": "tank"}}, "tank.yaml: cannot be read"),
    ],
)
def test_invalid_argument_is_named_in_one_line(arguments, message):
    with pytest.raises(ValueError, match="") as error:
        drive(**arguments)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_collision_with_a_pedestrian_that_came_during_the_drive_is_one_with_a_pedestrian():
    setup = drive_setup()
    world = setup.simulation()
    rules = evaluation_rules(node_parameters("local_planner"))
    recorder = DriveRecorder(rules, setup.waypoints_m, world)
    walker = ObstacleState(10001, "pedestrian", 5.0, 0.0, 0.0, 0.5, 0.5, 1.75, 1.0)
    hit = CollisionEvent(10001, 0.0, 0.0)
    snapshot = world.snapshot._replace(obstacles=(walker,), collisions=(hit,))
    recorder.add(snapshot, None, SimpleNamespace(path=None, reason=""))
    infractions = recorder.evaluator.result().metrics["infractions"]
    assert infractions["collision_pedestrian"] == 1 and infractions["collision_vehicle"] == 0


def test_planner_function_that_returns_no_rows_is_named():
    with pytest.raises(TypeError, match="plan must return rows x, y, v or a Path, got None"):
        drive(planner=lambda _: None)
