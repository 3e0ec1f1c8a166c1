"""The evaluated drive: its status, its metrics and what else its report shows."""

import math
import resource

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from referee_rules import RULES, TICK_NS, with_route

from sdc_common.planning.speed_profile import SpeedLimits
from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.evaluation.event_file import EventFile
from sdc_sim.evaluation.rules import EvaluationRules
from sdc_sim.physics.traffic_lights import GREEN, RED


def drive_on(evaluator, first, ticks, speed=10.0, answer=True):
    for tick in range(first, first + ticks):
        x, wall_s = min(0.05 * speed * tick, 100.0), 100.0 + 0.01 * tick
        now = speed if x < 100.0 else 0.0
        evaluator.add("odometry", tick * TICK_NS, x, 0.2, 0.0, now, wall_s)
        if answer:
            evaluator.add("command", tick * TICK_NS, 0.001 * tick, 0.0, -0.1)


def test_metrics_of_a_complete_drive():
    evaluator = with_route()
    drive_on(evaluator, 1, 300)
    result = evaluator.result()
    metrics = result.metrics
    assert metrics["status"] == "completed"
    assert metrics["duration_s"] == pytest.approx(9.95)
    assert metrics["ticks"] == 200
    assert metrics["missed_ticks"] == 0
    assert metrics["cross_track_rms_m"] == pytest.approx(0.2)
    assert metrics["wall_duration_s"] == pytest.approx(102.0 - 100.01), (
        "from the first odometry to the one that ends the drive"
    )
    assert metrics["real_time_factor"] == pytest.approx(9.95 / 1.99)
    np.testing.assert_allclose(result.rows[:, -3], 0.001 * np.arange(1, 201))


def test_new_mission_continues_the_drive_along_both():
    """The car drives 50 m of a straight, and then a mission that turns left there."""
    evaluator = with_route(rules=RULES._replace(new_missions=True))
    drive_on(evaluator, 1, 100)
    turn = [(50.0 + x, 0.0) for x in range(5)] + [(54.0, float(y)) for y in range(1, 31)]
    for _ in range(2):
        evaluator.set_route(turn)  # the same one again changes nothing
    before = evaluator.drive.progress.progress_m
    assert (before, evaluator.drive.route.length_m) == pytest.approx((50.0, 84.0), abs=0.6)
    for tick in range(101, 210):
        along = 0.5 * (tick - 100)
        x, y, yaw = (50 + along, 0.0, 0.0) if along < 4 else (54.0, along - 4.0, np.pi / 2)
        speed = 10.0 if y < 30.0 else 0.0
        evaluator.add("odometry", tick * TICK_NS, x, min(y, 30.0), yaw, speed, 1.0)
    metrics = evaluator.result().metrics
    assert metrics["status"] == "completed"
    assert metrics["route_length_m"] == pytest.approx(84.0, abs=0.6)
    assert metrics["cross_track_max_m"] < 0.6


def test_later_mission_is_ignored_without_the_rule():
    evaluator = with_route()
    drive_on(evaluator, 1, 100)
    evaluator.set_route([(50.0, 0.0), (50.0, 40.0)])
    assert evaluator.drive.route.length_m == pytest.approx(100.0)


def test_least_time_of_a_late_start_is_that_of_the_rest_of_the_route():
    late = with_route()
    drive_on(late, 80, 200)
    metrics, ideal = late.result().metrics, late.drive.ideal
    assert metrics["status"] == "completed"
    assert metrics["ideal_duration_s"] == pytest.approx(ideal.duration_s - ideal.time_at(40.0))


def test_evaluator_keeps_events_that_arrive_before_the_route():
    early, evaluator = Evaluator(RULES), with_route()
    for each in (early, evaluator):
        drive_on(each, 1, 30)
    assert early.missing_topics == ["/planner/mission_waypoints"]
    early.set_route(evaluator.drive.route.points)
    assert early.missing_topics == []
    assert early.result().metrics == evaluator.result().metrics


@pytest.mark.parametrize(
    ("number", "kind"),
    [(101, "vehicle"), (102, "pedestrian"), (103, "static"), (7, "vehicle"), (0, "static")],
)
def test_collision_is_reported_by_the_kind_of_obstacle(number, kind):
    evaluator = with_route()
    for known, name in ((101, "car"), (102, "pedestrian"), (103, "obstacle")):
        evaluator.add("obstacle", known, name)
    drive_on(evaluator, 1, 50)
    evaluator.add("collision", 40 * TICK_NS, number)
    metrics = evaluator.result().metrics
    assert metrics["status"] == "collision"
    assert {name for name, count in metrics["infractions"].items() if count} == {
        "collision_" + kind
    }
    assert metrics["ticks"] == 40


@pytest.mark.slow(2)
@given(st.lists(st.sampled_from(["odometry", "collision"]), min_size=1))
def test_collision_ends_the_drive_at_its_stamp_in_any_order_of_arrival(order):
    evaluator = with_route()
    drive_on(evaluator, 1, 20)
    tick = 21
    added = False
    for what in (*order, "collision"):
        if what == "odometry" and tick < 60:
            drive_on(evaluator, tick, 1)
            tick += 1
        elif what == "collision" and not added:
            evaluator.add("collision", 30 * TICK_NS, 5)
            added = True
    drive_on(evaluator, tick, 30)
    assert evaluator.result().metrics["ticks"] == 30
    assert evaluator.result().progress.samples[-1].s_m == pytest.approx(15.0)


@pytest.mark.parametrize("max_bytes", [resource.RLIM_INFINITY, 9999])
def test_drive_in_a_file_of_events_is_that_in_memory(tmp_path, request, max_bytes):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    request.addfinalizer(lambda: resource.setrlimit(resource.RLIMIT_FSIZE, before))
    resource.setrlimit(resource.RLIMIT_FSIZE, (max_bytes, before[1]))
    failures = []
    in_memory = with_route()
    in_file = with_route(EventFile(str(tmp_path / "events"), failures.append))
    for evaluator in (in_memory, in_file):
        for tick in range(1, 31):
            evaluator.add("reason", 10 * tick * TICK_NS, f"reason {tick}")
        drive_on(evaluator, 1, 50)
        evaluator.add("planned", 3.0)
        drive_on(evaluator, 51, 250)
    assert len(in_file.drive.progress.samples) == 1, "the others are not in memory"
    assert len(failures) == (max_bytes == 9999), "the drive continues, which is reported once"
    expected, found = in_memory.result(), in_file.result()
    assert found.metrics == expected.metrics
    assert found.reasons == expected.reasons
    np.testing.assert_array_equal(found.rows, expected.rows)
    np.testing.assert_array_equal(found.planned, expected.planned)


@pytest.mark.parametrize(("red", "count"), [(range(97, 300), 0), (range(96, 97), 1)])
@pytest.mark.parametrize("kept", [False, True])
def test_red_light_counts_when_the_front_crosses_the_line(red, count, kept, tmp_path):
    """At 10 m/s, the car's front reaches the stop line at 50 m in tick 96."""
    evaluator = with_route(EventFile(str(tmp_path / "events")) if kept else None)
    evaluator.add("stop_lines", [(7, 50.0, 0.0, 1.75)])
    for tick in range(1, 201):
        drive_on(evaluator, tick, 1)
        evaluator.add("lights", tick * TICK_NS, [(7, RED if tick in red else GREEN)])
    metrics = evaluator.result().metrics
    assert metrics["infractions"]["red_light"] == count
    assert (metrics["driving_score"] < 99.0) == bool(count)


@pytest.mark.parametrize(("line_m", "ends_s"), [(50.0, 70.0), (30.0, 30.0), (400.0, 30.0)])
def test_car_that_waits_for_a_red_light_is_not_blocked(line_m, ends_s):
    """The car stands at 40 m; a light is red for 40 s on its way, behind it, or on no way."""
    evaluator = with_route(rules=RULES._replace(blocked_s=30.0))
    evaluator.add("stop_lines", [(7, line_m, 0.0, 1.75)])
    tick = 0
    while evaluator.drive.progress.status is None and tick < 2000:
        tick += 1
        evaluator.add("lights", tick * TICK_NS, [(7, RED if tick * 0.05 < 40.0 else GREEN)])
        evaluator.add("odometry", tick * TICK_NS, 40.0, 0.0, 0.0, 0.0, 1.0)
    assert evaluator.drive.progress.status == "blocked"
    assert tick * 0.05 == pytest.approx(ends_s, abs=0.2)


@pytest.mark.parametrize(
    ("events", "awaits"),
    [
        ([], False),  # a stack that publishes nothing
        ([("command", 0, 0.5, 0.0, 0.0)], False),  # one without stamps
        ([("command", 9 * TICK_NS, 0.5, 0.0, 0.0)], True),
        ([("command", 10 * TICK_NS, 0.5, 0.0, 0.0)], False),
        ([("command", 10 * TICK_NS, 0.5, 0.0, 0.0), ("reason", TICK_NS, "bend")], True),
        ([("command", 10 * TICK_NS, 0.5, 0.0, 0.0), ("reason", 9 * TICK_NS, "bend")], False),
    ],
)
def test_messages_about_the_last_tick_are_awaited_if_the_stack_stamps_them(events, awaits):
    evaluator = with_route()
    drive_on(evaluator, 1, 10, answer=False)
    for event in events:
        evaluator.add(*event)
    assert evaluator.drive.awaits_messages == awaits


@pytest.mark.parametrize(
    ("tick", "reason"),
    [(19, ""), (20, "start"), (40, "start"), (41, ""), (50, "bend"), (70, "bend"), (71, "")],
)
def test_reason_applies_from_its_stamp_on_for_a_second(tick, reason):
    evaluator = with_route()
    evaluator.add("reason", 50 * TICK_NS, "stop")
    evaluator.add("reason", 50 * TICK_NS, "bend")
    evaluator.add("reason", 20 * TICK_NS, "start")
    drive_on(evaluator, 1, 80, answer=False)
    assert evaluator.result().reasons[tick - 1] == reason


def test_result_holds_what_was_planned_photographed_and_seen():
    evaluator = with_route()
    evaluator.add("planned", 9.0)  # before the first odometry: at no place
    evaluator.add("stop_lines", [(7, 50.0, 0.0, 1.75)])
    drive_on(evaluator, 1, 2)
    evaluator.add("planned", 4.0)
    evaluator.add("snapshot", 0.1, 1.0, "YSBwaWN0dXJl")
    evaluator.add("lights", 2 * TICK_NS, [(7, RED)])
    evaluator.add("lights", 0, [(7, GREEN)])
    result = evaluator.result()
    np.testing.assert_allclose(result.planned, [[1.0, 4.0, 0.1]])
    assert result.snapshots == [(0.1, 1.0, "YSBwaWN0dXJl")]
    assert result.scene["lights"] == [(0.1, {7: RED}), (0.1, {7: GREEN})]
    assert list(result.stop_lines) == [7]
    assert result.ideal.speed_mps.shape == (len(evaluator.drive.route.points),)
    assert result.ideal.speed_mps.max() == pytest.approx(RULES.speed_limits().cruise_mps, rel=0.5)


def test_result_counts_the_answers_by_stamp_and_by_order():
    evaluator = with_route()
    drive_on(evaluator, 1, 3, speed=1.0)
    evaluator.add("odometry", 4 * TICK_NS, 0.2, 0.2, 0.0, 1.0)
    evaluator.add("command", 0, 0.5, 0.0, 0.0)
    metrics = evaluator.result().metrics
    assert (metrics["ticks_by_stamp"], metrics["ticks_by_order"]) == (3, 1)
    assert metrics["assumed_limits"] == list(RULES.assumed)


def test_error_of_the_camera_is_that_at_the_stamps_of_its_pictures():
    evaluator = with_route()
    drive_on(evaluator, 1, 40, speed=1.0)
    assert "lane_offset_rms_error_m" not in evaluator.result().metrics
    for tick, offset_m in ((2, 0.3), (3, 0.1), (4, math.nan), (39, 9.0), (50, 9.0)):
        evaluator.add("lane_offset", tick * TICK_NS, offset_m)
    metrics = evaluator.result().metrics
    assert metrics["lane_offset_rms_error_m"] == pytest.approx(0.1), "the car is at 0.2 m"


def test_each_time_without_odometry_is_added():
    evaluator = with_route()
    for first in (1, 40, 80):
        drive_on(evaluator, first, 10, speed=1.0)
    assert evaluator.result().metrics["unseen_s"] == pytest.approx((30 + 31) * 0.05)


@pytest.mark.parametrize(
    ("stamps", "accepted"),
    [([1, 1, 2, 80], [1, 2, 80]), ([200, 198, 201, 199, 202], [200, 201, 202])],
    ids=["repeated", "second publisher"],
)
def test_odometry_that_is_not_newer_is_ignored(stamps, accepted):
    evaluator = with_route()
    found = [n for n in stamps if evaluator.add("odometry", n * TICK_NS, 0.0, 0.0, 0.0, 1.0)]
    assert found == accepted
    assert evaluator.result().metrics["ticks"] == len(accepted)


def test_nothing_counts_after_the_end():
    evaluator = with_route()
    evaluator.add("stop_lines", [(7, 50.0, 0.0, 1.75)])
    drive_on(evaluator, 1, 100, speed=9.5)
    evaluator.add("collision", 95 * TICK_NS, 0)
    assert evaluator.over
    before = evaluator.result().metrics
    drive_on(evaluator, 101, 10, speed=9.5)
    evaluator.add("lights", 100 * TICK_NS, [(7, RED)])
    evaluator.add("collision", 105 * TICK_NS, 3)
    evaluator.add("planned", 1.0)
    assert evaluator.result().metrics == before
    assert len(evaluator.result().planned) == 0
    assert not evaluator.add("odometry", 111 * TICK_NS, 50.0, 0.0, 0.0, 1.0)


# Each number differs from all others.
NAMES = "off_route_m off_route_s blocked_s finish_within_m timeout_ratio timeout_margin_s"
LIMITS = "planned_speed_mps lateral_acceleration_mps2 acceleration_mps2 braking_mps2"
PARAMETERS = {name: 1.5 + number for number, name in enumerate(NAMES.split())}
PARAMETERS.update(lane_width_m=3.25, car_front_m=3.8, finish_at_rest=False, new_missions=True)
PLANNER = {name: 11.0 + number for number, name in enumerate(LIMITS.split())}
PLANNER.update(lateral_jerk_mps3=1.0, curve_ahead_m=20.0)
PARAMETERS.update(map="town.net.xml", assumed_planner=PLANNER)


def read(**changes):
    return EvaluationRules.read({**PARAMETERS, **changes}.__getitem__)


def test_each_rule_is_the_parameter_of_its_name():
    rules, expected = read()._asdict(), {**PARAMETERS}
    del rules["planner"], rules["assumed"], expected["assumed_planner"]
    assert rules == expected


def test_limits_of_the_planner_are_those_of_the_speed_profile():
    limits = {"cruise_mps": 11.0, "lateral_mps2": 12.0, "acceleration_mps2": 13.0}
    limits.update(braking_mps2=14.0, lateral_jerk_mps3=1.0)
    assert read().speed_limits() == SpeedLimits(**limits)


def test_timeout_is_the_ratio_of_the_ideal_duration_and_a_margin():
    assert read(timeout_ratio=2.0, timeout_margin_s=30.0).timeout_s(100.0) == 230.0


@pytest.mark.parametrize(
    ("name", "value"), [("blocked_s", 0.0), ("finish_at_rest", "no"), ("new_missions", 1)]
)
def test_rule_with_a_wrong_value_is_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        read(**{name: value})
