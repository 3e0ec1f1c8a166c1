"""A drive of many laps leaves every process as it was: ten simulated minutes here, hours by rosrun sdc_sim soak.py."""

import os
import subprocess
import sys

import numpy as np
import pytest

from sdc_experiments.soak import LAP, SPEED_MPS, ProcessSample, judge, laps

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scripts", "soak.py")


def drive(memory, files=lambda percent: 10):
    return [
        ProcessSample(percent, memory(percent), files(percent))
        for percent in np.arange(0.0, 100.5, 0.5)
    ]


def test_flat_is_flat_whatever_the_start_and_the_end_take():
    verdict = judge(
        drive(lambda percent: 40.0 + min(percent, 20.0) + (50.0 if percent > 99.9 else 0.0))
    )
    assert verdict == (60.0, 0.0, 0)


def test_a_leak_is_seen():
    verdict = judge(
        drive(lambda percent: 40.0 + 0.1 * percent, lambda percent: 10 + int(percent // 30))
    )
    assert verdict.growth_mb == pytest.approx(7.5, abs=0.3)
    assert verdict.leaked_files == 3


def test_files_that_come_and_go_are_no_leak():
    assert (
        judge(drive(lambda percent: 40.0, lambda percent: 10 + int(percent) % 2)).leaked_files == 0
    )


def test_a_process_that_was_not_there_is_not_judged():
    assert judge(drive(lambda percent: 1.0)[:20]) is None


@pytest.mark.parametrize("hours", [0.01, 0.5, 10.0])
def test_laps_are_long_enough_and_have_no_gap(hours):
    points = laps(hours)
    steps = np.hypot(*np.diff(points, axis=0).T)
    assert steps.sum() >= 3600.0 * hours * SPEED_MPS - 2.0
    assert steps.min() > 0.5
    assert steps.max() < 1.5
    assert len(LAP) == 4


def test_ten_simulated_minutes():
    done = subprocess.run(
        [sys.executable, SCRIPT, "hours:=0.1667"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=380,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    for name in (
        "sim",
        "referee",
        "local_planner",
        "simple_controller",
        "mission_planner",
        "rosmaster",
    ):
        assert f"| {name} |" in done.stdout
