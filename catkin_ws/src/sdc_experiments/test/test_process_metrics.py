"""Test the metrics of processes with programs that stand in for nodes."""

import os
import subprocess
import sys

import psutil
import pytest

from sdc_experiments.process_metrics import cpu_ms, private_memory_mb, stack_processes

pytestmark = pytest.mark.slow(3)

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
