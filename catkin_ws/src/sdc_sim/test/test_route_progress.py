import math

import numpy as np
import pytest

from sdc_common.geometry.route import Route
from sdc_sim.evaluation.route_progress import (
    ABORTED,
    BLOCKED,
    COLLISION,
    COMPLETED,
    OFF_ROUTE,
    TIMEOUT,
    RouteProgress,
    TerminationLimits,
)

LIMITS = TerminationLimits(
    off_route_m=15.0, off_route_s=0.5, blocked_s=30.0, finish_within_m=2.0, timeout_s=300.0
)
STRAIGHT = Route(np.column_stack([np.arange(101.0), np.zeros(101)]))


def circle(radius, turns):
    angle = np.arange(0.0, turns * 2.0 * math.pi, 1.0 / radius)
    return Route(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]))


def drive_straight(speed=10.0, offset=0.0, stop_at=100.0, rest_s=5.0, tick=0.05, limits=LIMITS):
    drive = RouteProgress(STRAIGHT, limits)
    time, x = 0.0, 0.0
    while drive.status is None and time < 400.0:
        now = speed if x < stop_at else 0.0
        drive.update(time, x, offset, 0.0, now)
        x = min(stop_at, x + now * tick)
        time += tick
        if now == 0.0 and time > stop_at / speed + rest_s and rest_s < 10.0:
            break
    return drive


def test_metrics_of_a_drive_parallel_to_the_route():
    drive = drive_straight(offset=0.3)
    metrics = drive.metrics(10.0)
    assert metrics["status"] == COMPLETED
    assert metrics["cross_track_rms_m"] == pytest.approx(0.3)
    assert metrics["cross_track_max_m"] == pytest.approx(0.3)
    assert metrics["route_completion_percent"] == 100.0
    assert metrics["duration_s"] == pytest.approx(10.0, abs=0.1)
    assert metrics["time_ratio"] == pytest.approx(1.0, abs=0.01)
    assert metrics["speed_max_mps"] == 10.0
    assert metrics["cross_track_p95_m"] == pytest.approx(0.3)
    assert metrics["off_lane_percent"] == 0.0
    assert drive.metrics(10.0, lane_width_m=0.5)["off_lane_percent"] == pytest.approx(100.0)


def test_cross_track_error_is_positive_left_of_the_route():
    assert drive_straight(offset=0.3).samples[5].cross_track_m == pytest.approx(0.3)
    assert drive_straight(offset=-0.3).samples[5].cross_track_m == pytest.approx(-0.3)


def test_metrics_of_a_circle_at_constant_speed():
    route = circle(20.0, 1.3)
    drive = RouteProgress(route, LIMITS)
    for tick in range(int(1.2 * 2.0 * math.pi * 20.0 / 5.0 / 0.05)):
        angle = 5.0 * 0.05 * tick / 20.0
        drive.update(
            tick * 0.05,
            20.2 * math.cos(angle),
            20.2 * math.sin(angle),
            angle + math.pi / 2,
            5.0 * 20.2 / 20.0,
        )
    metrics = drive.metrics(30.0)
    assert metrics["cross_track_rms_m"] == pytest.approx(0.2, abs=0.01)
    assert drive.samples[-1].cross_track_m < 0.0, "outside of a left bend is right"
    assert metrics["lateral_acceleration_max_mps2"] == pytest.approx(5.05**2 / 20.2, rel=0.02)
    assert metrics["longitudinal_acceleration_max_mps2"] == pytest.approx(0.0, abs=1e-9)
    assert metrics["route_completion_percent"] == pytest.approx(100.0 * 1.2 / 1.3, abs=0.5), (
        "the second round is not the first"
    )
    assert metrics["heading_rms_rad"] < 0.03
    assert metrics["speed_mean_mps"] == pytest.approx(5.05)
    assert metrics["jerk_max_mps3"] == pytest.approx(0.0, abs=1e-6)
    assert metrics["comfortable"] is True


def test_constant_acceleration_is_measured():
    drive = RouteProgress(STRAIGHT, LIMITS)
    for tick in range(100):
        time = tick * 0.05
        drive.update(time, time * time, 0.0, 0.0, 2.0 * time)
    metrics = drive.metrics(10.0)
    assert metrics["longitudinal_acceleration_max_mps2"] == pytest.approx(2.0, abs=1e-6)
    assert metrics["longitudinal_acceleration_min_mps2"] == pytest.approx(2.0, abs=1e-6)
    assert metrics["jerk_max_mps3"] == pytest.approx(0.0, abs=1e-6)


def test_slow_car_is_not_blocked():
    assert drive_straight(speed=0.5).status == COMPLETED


def test_car_at_rest_is_blocked():
    assert drive_straight(stop_at=50.0, rest_s=1e9).status == BLOCKED


def test_slow_drive_ends_with_a_timeout():
    slow = LIMITS._replace(timeout_s=20.0)
    drive = drive_straight(speed=1.0, limits=slow)
    assert drive.status == TIMEOUT
    assert drive.completion_percent == pytest.approx(20.0, abs=1.0)


def test_drive_ends_when_the_car_leaves_the_route():
    drive = RouteProgress(STRAIGHT, LIMITS)
    for tick in range(200):
        drive.update(tick * 0.05, 5.0 + tick * 0.1, tick * 0.1, 0.7, 3.0)
        if drive.status:
            break
    assert drive.status == OFF_ROUTE


def test_teleport_is_off_route_even_onto_another_part():
    drive = RouteProgress(STRAIGHT, LIMITS)
    drive.update(0.0, 5.0, 0.0, 0.0, 3.0)
    for tick in range(1, 20):
        drive.update(0.05 * tick, 80.0, 0.0, 0.0, 3.0)
        if drive.status:
            break
    assert drive.status == OFF_ROUTE
    assert drive.samples[-1].time_s == pytest.approx(0.55)
    metrics = drive.metrics(10.0)
    assert metrics["cross_track_max_m"] > 15.0
    assert metrics["route_completion_percent"] < 20.0
    assert metrics["comfortable"] is True, (
        "a place that leaps is no acceleration: speed and heading did not change"
    )


def test_single_odometry_far_away_does_not_end_the_drive():
    drive = RouteProgress(STRAIGHT, LIMITS)
    for tick in range(41):
        drive.update(0.05 * tick, 0.5 * tick + (50.0 if tick == 20 else 0.0), 0.0, 0.0, 10.0)
    assert drive.status is None
    assert drive.samples[-1].cross_track_m == pytest.approx(0.0)
    assert drive.samples[-1].s_m == pytest.approx(20.0)
    assert drive.metrics(10.0)["cross_track_max_m"] > 30.0, "the metrics contain it"


def test_search_reaches_farther_ahead_after_a_gap():
    drive = RouteProgress(STRAIGHT, LIMITS)
    drive.update(0.0, 5.0, 0.0, 0.0, 10.0)
    drive.update(4.0, 45.0, 0.1, 0.0, 10.0)
    assert drive.samples[-1].s_m == pytest.approx(45.0)
    assert drive.metrics(10.0)["cross_track_max_m"] == pytest.approx(0.1)


def test_unfinished_drive_is_aborted():
    drive = drive_straight(stop_at=60.0, rest_s=1.0)
    metrics = drive.metrics(10.0)
    assert metrics["status"] == "aborted"
    assert metrics["route_completion_percent"] == pytest.approx(60.0, abs=0.5)


def test_car_arrives_when_it_is_at_rest_and_not_before():
    drive = RouteProgress(STRAIGHT, LIMITS)
    drive.update(0.0, 90.0, 0.0, 0.0, 5.0)
    drive.update(0.05, 99.9, 0.0, 0.0, 5.0)
    assert drive.status is None
    drive.update(0.1, 100.5, 0.0, 0.0, 0.0)
    assert drive.status == COMPLETED


def test_time_that_goes_back_is_refused():
    drive = RouteProgress(STRAIGHT, LIMITS)
    drive.update(1.0, 0.0, 0.0, 0.0, 0.0)
    with pytest.raises(ValueError, match="time went"):
        drive.update(0.5, 0.0, 0.0, 0.0, 0.0)


def test_jerk_of_a_single_sample_is_unknown():
    drive = RouteProgress(STRAIGHT, LIMITS)
    drive.update(1.0, 0.0, 0.0, 0.0, 0.0)
    assert drive.metrics(10.0)["jerk_max_mps3"] is None


def test_limits_must_be_positive():
    with pytest.raises(ValueError, match="blocked_s"):
        RouteProgress(STRAIGHT, LIMITS._replace(blocked_s=0.0))


def drive_at(speed, ticks, drive=None, first=0):
    drive = drive or RouteProgress(STRAIGHT, LIMITS)
    for tick in range(first, first + ticks):
        drive.update(0.05 * tick, speed * 0.05 * tick, 0.0, 0.0, speed)
    return drive


@pytest.mark.parametrize(
    ("kind", "score"), [("pedestrian", 50.0), ("vehicle", 100.0 / 1.7), ("static", 62.5)]
)
def test_collision_ends_the_drive_and_counts_by_its_kind(kind, score):
    drive = drive_at(10.0, 11)
    drive.add_collision(kind)
    metrics = drive.metrics(10.0)
    assert metrics["status"] == COLLISION
    assert metrics["infractions"] == {
        **dict.fromkeys(metrics["infractions"], 0),
        "collision_" + kind: 1,
    }
    assert metrics["driving_score"] == pytest.approx(0.01 * score * 5.0), "5 m of 100 m"
    assert [event.name for event in drive.events] == ["collision_" + kind, COLLISION]
    drive.add_collision(kind)
    assert drive.infractions["collision_" + kind] == 1


def test_collision_ends_the_drive_at_its_own_time_in_any_order_of_arrival():
    late, early = drive_at(10.0, 31), drive_at(10.0, 11)
    late.add_collision("vehicle", 1.0)
    early.add_collision("vehicle", 1.0)
    assert early.status is None
    drive_at(10.0, 10, early, first=11)
    assert late.status == early.status == COLLISION
    assert late.samples == early.samples
    assert late.metrics(10.0) == early.metrics(10.0)
    assert drive_at(10.0, 21).metrics(10.0)["status"] == ABORTED


def test_other_infractions_count_and_the_drive_continues():
    drive = drive_at(10.0, 11)
    drive.add_infraction("red_light")
    drive.add_infraction("red_light")
    drive.add_infraction("stop")
    assert drive.status is None
    metrics = drive.metrics(10.0)
    assert (metrics["infractions"]["red_light"], metrics["infractions"]["stop"]) == (2, 1)
    assert metrics["driving_score"] == pytest.approx(5.0 / (1.0 + 2 * 0.4 + 0.25))
    with pytest.raises(ValueError, match="red_light"):
        drive.add_infraction("red_lihgt")


def test_drive_without_kept_samples_keeps_the_last_one():
    drive = RouteProgress(STRAIGHT, LIMITS, keep_samples=False)
    drive_at(10.0, 100, drive)
    assert len(drive.samples) == 1
    assert drive.duration_s == pytest.approx(99 * 0.05)


def test_drive_that_need_not_stop_is_completed_where_it_passes_the_end():
    limits = LIMITS._replace(finish_at_rest=False)
    drive = drive_straight(stop_at=200.0, limits=limits)
    assert drive.status == COMPLETED
    assert 98.0 <= drive.samples[-1].x_m < 99.0
    assert drive.samples[-1].speed_mps == 10.0


def test_drive_that_passes_the_end_is_not_completed():
    assert drive_straight(stop_at=200.0).status != COMPLETED


def test_finish_that_is_neither_true_nor_false_is_refused():
    with pytest.raises(ValueError, match="finish_at_rest"):
        RouteProgress(STRAIGHT, LIMITS._replace(finish_at_rest="no"))
