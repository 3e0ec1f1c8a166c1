"""What a drive that lasts, has collided or is forgotten in part says of itself."""

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
    DriveEvent,
    RouteProgress,
    TerminationLimits,
)

LIMITS = TerminationLimits(
    off_route_m=15.0, off_route_s=0.5, blocked_s=30.0, finish_within_m=2.0, timeout_s=300.0
)
STRAIGHT = Route(np.column_stack([np.arange(101.0), np.zeros(101)]))


def drive(samples, start_s=100.0, speed=10.0, y_m=0.5, first_m=0.0):
    """Return a drive of so many samples, 0.1 s and 1 m apart."""
    progress = RouteProgress(STRAIGHT, LIMITS)
    for i in range(samples):
        progress.update(start_s + 0.1 * i, first_m + i, y_m, 0.01, speed)
    return progress


def test_drive_that_has_not_begun_has_no_duration_and_no_progress():
    progress = RouteProgress(STRAIGHT, LIMITS)
    assert (progress.duration_s, progress.progress_m, progress.completion_percent) == (0, 0, 0)
    assert progress.rows.shape == (0, 8)
    progress.add_infraction("red_light")
    assert progress.infractions["red_light"] == 1
    assert progress.events == []


def test_duration_and_progress_count_from_the_first_odometry():
    progress = drive(31)
    assert progress.duration_s == pytest.approx(3.0)
    assert progress.completion_percent == pytest.approx(30.0)
    metrics = progress.metrics(2.0)
    assert metrics["status"] == ABORTED
    assert (metrics["route_length_m"], metrics["ideal_duration_s"]) == (100.0, 2.0)
    assert metrics["time_ratio"] == pytest.approx(1.5)


def test_columns_are_those_of_the_samples():
    progress = drive(3)
    assert progress.rows.tolist() == [list(sample) for sample in progress.samples]
    np.testing.assert_allclose(progress.column("time_s"), [100.0, 100.1, 100.2])
    np.testing.assert_allclose(progress.column("x_m"), [0.0, 1.0, 2.0])
    np.testing.assert_allclose(progress.column("y_m"), 0.5)
    np.testing.assert_allclose(progress.column("yaw_rad"), 0.01)
    np.testing.assert_allclose(progress.column("heading_error_rad"), 0.01)


def test_event_has_the_time_and_the_place_of_the_last_sample():
    progress = drive(6)
    progress.add_infraction("red_light")
    progress.update(100.6, 6.0, 0.5, 0.0, 10.0)
    progress.add_collision("static")
    assert progress.events == [
        DriveEvent("red_light", pytest.approx(100.5), pytest.approx(5.0), 5.0, 0.5),
        DriveEvent("collision_static", pytest.approx(100.6), pytest.approx(6.0), 6.0, 0.5),
        DriveEvent(COLLISION, pytest.approx(100.6), pytest.approx(6.0), 6.0, 0.5),
    ]


def test_car_that_passes_the_start_of_the_route_faces_along_it():
    """Two passes at the start: the heading tells which one the car is on."""
    there_and_back = Route([(0.0, 0.0), (50.0, 0.0), (50.0, 1.0), (0.0, 1.0)])
    for yaw_rad, s_m in ((0.0, 10.0), (np.pi, 91.0)):
        progress = RouteProgress(there_and_back, LIMITS)
        assert progress.update(0.0, 10.0, 0.5, yaw_rad, 1.0).s_m == pytest.approx(s_m, abs=1.0)


@pytest.mark.parametrize("forgotten", [0, 20, 40])
def test_forgotten_samples_still_count(forgotten):
    whole, progress = drive(50), drive(50)
    rows = progress.rows[:forgotten]
    progress.forget(forgotten)
    assert len(progress.samples) == 50 - forgotten
    assert progress.metrics(2.0, 4.0, rows) == whole.metrics(2.0, 4.0)


def test_collision_of_an_earlier_time_takes_the_progress_after_it_back():
    progress = drive(50)
    progress.forget(20)
    progress.add_collision("vehicle", 103.0)
    assert progress.progress_m == pytest.approx(30.0)
    assert len(progress.samples) == 11


def test_collision_before_all_kept_samples_keeps_the_oldest_and_the_forgotten_progress():
    progress = drive(50)
    progress.forget(20)
    progress.add_collision("vehicle", 100.5)
    assert [sample.time_s for sample in progress.samples] == [pytest.approx(102.0)]
    assert (progress.status, progress.progress_m) == (COLLISION, pytest.approx(20.0))
    early = drive(50)
    early.forget(20)
    early.samples = [early.samples[0]._replace(cross_track_m=20.0)]
    early.add_collision("vehicle", 100.5)
    assert early.progress_m == pytest.approx(19.0)


def test_drive_that_waits_for_the_odometry_of_its_collision_is_one():
    progress = drive(5)
    progress.add_collision("pedestrian", 100.6)
    assert progress.status is None
    assert progress.metrics(2.0)["status"] == COLLISION
    progress.update(100.5, 5.0, 0.5, 0.0, 10.0)
    assert progress.status is None
    progress.update(100.6, 6.0, 0.5, 0.0, 10.0)
    assert progress.status == COLLISION


def test_completed_drive_has_the_whole_route_behind_it():
    progress = drive(100, first_m=0.0)
    progress.update(110.0, 98.5, 0.5, 0.0, 0.0)
    assert progress.status == COMPLETED
    assert progress.progress_m < 100.0
    assert progress.completion_percent == 100.0


def test_time_must_go_on():
    progress = drive(2)
    with pytest.raises(ValueError, match=r"^time went from 100\.100 s to 100\.100 s$"):
        progress.update(100.1, 2.0, 0.0, 0.0, 10.0)


def test_unknown_infraction_gets_the_list_of_the_known_ones():
    with pytest.raises(ValueError, match="^unknown infraction 'red'; write one of .*, red_light"):
        drive(1).add_infraction("red")


def test_progress_of_less_than_ten_centimetres_is_none():
    progress = RouteProgress(STRAIGHT, LIMITS._replace(blocked_s=3.0))
    for tick in range(31):
        progress.update(0.1 * tick, 5.0 + 0.003 * tick, 0.0, 0.0, 0.03)
    assert progress.status is None
    progress.update(3.2, 5.1, 0.0, 0.0, 0.03)
    assert progress.status == BLOCKED


@pytest.mark.parametrize(
    ("limits", "distance_m", "status"),
    [
        (LIMITS._replace(blocked_s=8.0), 0.0, BLOCKED),
        (LIMITS._replace(timeout_s=8.0), 0.0, TIMEOUT),
        (LIMITS._replace(off_route_s=8.0), 16.0, OFF_ROUTE),
    ],
)
def test_drive_may_last_as_long_as_a_limit_and_no_longer(limits, distance_m, status):
    progress = RouteProgress(STRAIGHT, limits)
    for time_s in range(9):
        progress.update(float(time_s), 0.0, distance_m, 0.0, 1.0)
    assert progress.status is None
    progress.update(8.25, 0.0, distance_m, 0.0, 1.0)
    assert progress.status == status


def test_car_at_the_limit_is_still_on_the_route():
    progress = RouteProgress(STRAIGHT, LIMITS)
    for tick in range(10):
        progress.update(0.25 * tick, float(tick), LIMITS.off_route_m, 0.0, 10.0)
    assert (progress.status, progress.progress_m) == (None, 9.0)
    progress.add_collision("vehicle", 2.0)
    assert progress.progress_m == 8.0


@pytest.mark.parametrize(
    ("x_m", "speed", "status"),
    [(98.0, 0.0, None), (98.25, 0.0, COMPLETED), (100.0, 0.05, None), (100.0, 0.04, COMPLETED)],
)
def test_drive_is_completed_near_the_end_and_at_rest(x_m, speed, status):
    progress = RouteProgress(STRAIGHT, LIMITS)
    progress.update(0.0, x_m, 0.0, 0.0, speed)
    assert progress.status == status
