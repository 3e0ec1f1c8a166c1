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


def test_odometry_is_reported_before_the_path():
    assert watchdog_with(1_000_000_000).timed_out(2_000_000_000) == "odometry"


def test_path_that_is_not_needed_does_not_time_out():
    watchdog = watchdog_with(1_000_000_000)
    assert watchdog.timed_out(1_000_000_000, path_needed=False) is None
    assert watchdog.timed_out(2_000_000_000, path_needed=False) == "odometry"


@pytest.mark.parametrize("timeout", [0.0, -0.1, math.nan, math.inf, "0.25", None])
def test_timeout_that_is_not_positive_is_refused(timeout):
    with pytest.raises(ValueError, match="patience_s"):
        InputWatchdog(timeout)
