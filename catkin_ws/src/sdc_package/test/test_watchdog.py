"""Timeouts of the controller's inputs, measured in simulated time."""

import math

import pytest

from sdc_package.watchdog import InputWatchdog

TIMEOUT_NS = 250_000_000


def watchdog_with(odometry_ns, path_ns=0):
    """Return a watchdog whose last path answered the odometry at `path_ns`."""
    watchdog = InputWatchdog(0.25)
    if path_ns:
        watchdog.odometry_received(path_ns)
        watchdog.path_received()
    watchdog.odometry_received(odometry_ns)
    return watchdog


@pytest.mark.parametrize(("late_ns", "missing"), [(0, None), (1, "odometry")])
def test_odometry_times_out_after_exactly_the_timeout(late_ns, missing):
    watchdog = watchdog_with(5_000_000_000, path_ns=5_000_000_000)
    assert watchdog.timed_out(5_000_000_000 + TIMEOUT_NS + late_ns) == missing


@pytest.mark.parametrize(("late_ns", "missing"), [(0, None), (1, "path")])
def test_path_times_out_after_exactly_the_timeout(late_ns, missing):
    now = 5_000_000_000 + TIMEOUT_NS + late_ns
    watchdog = watchdog_with(now, path_ns=5_000_000_000)
    assert watchdog.timed_out(now) == missing
    assert watchdog.path_timed_out == (missing == "path")


def test_path_age_does_not_depend_on_the_clock():
    watchdog = watchdog_with(5_100_000_000, path_ns=5_000_000_000)
    assert watchdog.timed_out(5_100_000_000 + TIMEOUT_NS) is None
    assert watchdog.timed_out(0) is None


def test_odometry_is_reported_before_the_path():
    assert watchdog_with(1_000_000_000).timed_out(2_000_000_000) == "odometry"


def test_path_that_never_arrives_times_out_but_is_not_late():
    watchdog = watchdog_with(1_000_000_000)
    assert watchdog.timed_out(1_000_000_000) == "path"
    assert not watchdog.path_timed_out


def test_path_that_is_not_needed_does_not_time_out():
    watchdog = watchdog_with(1_000_000_000)
    assert watchdog.timed_out(1_000_000_000, path_needed=False) is None
    assert watchdog.timed_out(2_000_000_000, path_needed=False) == "odometry"


def test_odometry_that_never_arrives_times_out_from_the_start_of_the_clock():
    assert InputWatchdog(0.25).timed_out(0) is None
    assert InputWatchdog(0.25).timed_out(TIMEOUT_NS) is None
    assert InputWatchdog(0.25).timed_out(TIMEOUT_NS + 1) == "odometry"


def test_path_of_the_first_nanosecond_can_be_late():
    assert watchdog_with(TIMEOUT_NS + 2, path_ns=1).path_timed_out


def test_long_timeout_is_exact():
    assert InputWatchdog(30.0).timed_out(30_000_000_000) is None
    assert InputWatchdog(30.0).timed_out(30_000_000_001) == "odometry"


@pytest.mark.parametrize("timeout", [0.0, -0.1, math.nan, math.inf, "0.25", None])
def test_timeout_that_is_not_positive_is_refused(timeout):
    with pytest.raises(ValueError, match="patience_s"):
        InputWatchdog(timeout)
