import numpy as np
import pytest
from referee_rules import RULES

from sdc_common.geometry.route import Route
from sdc_sim.evaluation.route_progress import (
    COLLISION,
    COMPLETED,
    OFF_ROUTE,
    DriveEvent,
    RouteProgress,
)

LIMITS = RULES._replace(
    off_route_m=15.0, off_route_s=0.5, blocked_s=30.0, finish_within_m=2.0, lane_width_m=3.5
)
STRAIGHT = Route(np.column_stack([np.arange(101.0), np.zeros(101)]))


def started(limits=LIMITS):
    return RouteProgress(STRAIGHT, limits, timeout_s=300.0)


def drive_straight(speed=10.0, offset=0.0, stop_at=100.0, limits=LIMITS):
    drive = started(limits)
    time, x = 0.0, 0.0
    while drive.status is None and time < 400.0:
        now = speed if x < stop_at else 0.0
        drive.update(time, x, offset, 0.0, now)
        x = min(stop_at, x + now * 0.05)
        time += 0.05
        if now == 0.0 and time > stop_at / speed + 5.0:
            break
    return drive


def test_place_after_a_gap_is_found_farther_ahead_and_errors_are_positive_left_of_the_route():
    drive = started()
    for time_s, x_m, y_m in ((0.0, 5.0, 0.0), (4.0, 45.0, 0.3), (4.1, 46.0, -0.3)):
        sample = drive.update(time_s, x_m, y_m, 0.0, 10.0)
        assert (sample.s_m, sample.cross_track_m) == (pytest.approx(x_m), pytest.approx(y_m))


def test_slow_car_is_not_blocked():
    assert drive_straight(speed=0.5).status == COMPLETED


def test_teleport_is_off_route_even_onto_another_part():
    drive = started()
    for tick in range(60):
        drive.update(0.05 * tick, 5.0 if tick < 41 else 80.0, 0.0, 0.0, 3.0)
        if drive.status:
            break
    assert drive.status == OFF_ROUTE
    assert drive.samples[-1].time_s == pytest.approx(2.55)
    metrics = drive.metrics(10.0)
    assert metrics["cross_track_max_m"] > 15.0
    assert metrics["route_completion_percent"] < 20.0
    assert metrics["comfortable"] is True, (
        "a place that leaps is no acceleration: speed and heading did not change"
    )


def test_single_odometry_far_away_does_not_end_the_drive():
    drive = started()
    for tick in range(41):
        drive.update(0.05 * tick, 0.5 * tick + (50.0 if tick == 20 else 0.0), 0.0, 0.0, 10.0)
    assert drive.status is None
    assert drive.samples[-1].cross_track_m == pytest.approx(0.0)
    assert drive.samples[-1].s_m == pytest.approx(20.0)
    assert drive.metrics(10.0)["cross_track_max_m"] > 30.0, "the metrics contain it"
    drive.update(2.05, 25.0, 30.0, 0.0, 10.0)
    assert drive.samples[-1].s_m > 24.0
    assert drive.completion_percent == pytest.approx(20.0), "the car has not passed that place"


def test_drive_that_need_not_stop_is_completed_where_it_passes_the_end():
    limits = LIMITS._replace(finish_at_rest=False)
    drive = drive_straight(stop_at=200.0, limits=limits)
    assert drive.status == COMPLETED
    assert 98.0 <= drive.samples[-1].x_m < 99.0
    assert drive.samples[-1].speed_mps == 10.0


def test_drive_that_passes_the_end_is_not_completed_and_its_error_is_that_across_the_route():
    drive = drive_straight(stop_at=200.0, offset=0.3)
    assert drive.status == OFF_ROUTE
    assert drive.samples[-1].x_m > 110.0
    assert drive.metrics(10.0)["cross_track_max_m"] == pytest.approx(0.3)


def test_event_has_the_time_and_the_place_of_the_last_sample():
    progress = started()
    for i in range(6):
        progress.update(100.0 + 0.1 * i, float(i), 0.5, 0.01, 10.0)
    progress.add_infraction("red_light")
    progress.update(100.6, 6.0, 0.5, 0.0, 10.0)
    progress.add_collision("static")
    assert progress.events == [
        DriveEvent("red_light", pytest.approx(100.5), pytest.approx(5.0), 5.0, 0.5),
        DriveEvent("collision_static", pytest.approx(100.6), pytest.approx(6.0), 6.0, 0.5),
        DriveEvent(COLLISION, pytest.approx(100.6), pytest.approx(6.0), 6.0, 0.5),
    ]


@pytest.mark.parametrize(
    ("x_m", "speed", "status"),
    [(98.0, 0.0, None), (98.25, 0.0, COMPLETED), (100.0, 0.05, None), (100.0, 0.04, COMPLETED)],
)
def test_drive_is_completed_near_the_end_and_at_rest(x_m, speed, status):
    progress = started()
    progress.update(0.0, x_m, 0.0, 0.0, speed)
    assert progress.status == status
