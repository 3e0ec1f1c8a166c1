"""Drive laps for ten simulated minutes; `rosrun sdc_experiments soak.py` drives for hours."""

import os
import subprocess
import sys

import numpy as np
import pytest

from sdc_experiments.soak import LAP, SPEED_MPS, judge, laps

pytestmark = pytest.mark.slow(30)

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scripts", "soak.py")


def samples(memory, files=lambda percent: 10):
    shares = np.arange(0.0, 100.5, 0.5)
    return np.array([(percent, memory(percent), files(percent)) for percent in shares])


def test_memory_of_start_and_end_does_not_count_as_growth():
    memory = lambda percent: 40.0 + min(percent, 20.0) + 50.0 * (percent > 99.9)  # noqa: E731
    assert judge(samples(memory)) == (60.0, 0.0, 0)


def test_growing_memory_and_open_files_are_measured():
    files = lambda percent: 10 + int(percent // 30)  # noqa: E731
    _, growth_mb, leaked = judge(samples(lambda percent: 40.0 + 0.1 * percent, files))
    assert (growth_mb, leaked) == (pytest.approx(7.5, abs=0.3), 3)


@pytest.mark.parametrize("hours", [0.01, 0.5, 10.0])
def test_laps_are_long_enough_and_have_no_gap(hours):
    points = laps(hours)
    steps = np.hypot(*np.diff(points, axis=0).T)
    assert steps.sum() >= 3600.0 * hours * SPEED_MPS - 2.0
    assert steps.min() > 0.5
    assert steps.max() < 1.5
    assert len(LAP) == 4


@pytest.mark.nightly
def test_processes_stay_flat_for_ten_simulated_minutes():
    done = subprocess.run(
        [sys.executable, SCRIPT, "hours:=0.1667"], capture_output=True, text=True, timeout=380
    )
    assert done.returncode == 0, done.stdout
    nodes = "sim referee local_planner simple_controller mission_planner rosmaster"
    for name in nodes.split():
        assert f"| {name} |" in done.stdout
