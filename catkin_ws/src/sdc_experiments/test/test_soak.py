"""Memory and time of processes, also over laps; `soak.py` drives for hours."""

import os
import subprocess
import sys

import numpy as np
import psutil
import pytest

from sdc_experiments.process_metrics import cpu_ms, private_memory_mb, stack_processes
from sdc_experiments.soak import LAP, SPEED_MPS, judge, laps

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
@pytest.mark.slow(30)
def test_processes_stay_flat_for_ten_simulated_minutes():
    done = subprocess.run(
        [sys.executable, SCRIPT, "hours:=0.1667"], capture_output=True, text=True, timeout=380
    )
    assert done.returncode == 0, done.stdout
    nodes = "sim referee local_planner simple_controller mission_planner rosmaster"
    for name in nodes.split():
        assert f"| {name} |" in done.stdout


MASTER_URI = f"http://127.0.0.1:1/test_{os.getpid()}"
BLOCK_MB = 40
# Uses memory and CPU time, then waits for the end of its standard input.
PROGRAM = f"""
import sys, time
block = bytearray(b"x" * ({BLOCK_MB} * 1024 * 1024))
end = time.process_time() + 0.3
while time.process_time() < end:
    pass
print("ready", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def node():
    command = [sys.executable, "-c", PROGRAM, "__name:=my_node"]
    options = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    environment = {**os.environ, "ROS_MASTER_URI": MASTER_URI}
    process = subprocess.Popen(command, env=environment, **options)
    assert process.stdout.readline() == "ready\n"
    yield psutil.Process(process.pid)
    process.communicate()


def test_stack_processes_are_those_with_the_master_uri(node):
    assert stack_processes(MASTER_URI) == [node]
    assert stack_processes(MASTER_URI + "_other") == []


def test_cpu_time_is_that_of_the_node(node):
    (used,) = cpu_ms(MASTER_URI).items()
    assert used[0] == "my_node"
    assert 300.0 <= used[1] < 5000.0


def test_memory_contains_what_the_node_uses(node):
    assert BLOCK_MB < private_memory_mb(node) < BLOCK_MB + 60.0
