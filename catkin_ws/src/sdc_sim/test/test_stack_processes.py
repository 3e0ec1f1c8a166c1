"""A tick without stamps waits for processes that are at work."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from sdc_common.testing.message_listener import wait_until
from sdc_sim.ros.stack_processes import StackProcesses, nodes_to

BUSY = "while True: pass"
IDLE = "import time; time.sleep(600)"
# A process waits for its vfork in the state in which it waits for a disk.
WAITS_FOR_DISK = """
import ctypes, time
libc = ctypes.CDLL(None)
if libc.vfork() == 0:
    PR_SET_PDEATHSIG, SIGKILL = 1, 9
    libc.prctl(PR_SET_PDEATHSIG, SIGKILL)
    time.sleep(600)
"""
SECOND_THREAD = f"import threading; threading.Thread(target=lambda: exec('{BUSY}')).start(); {IDLE}"


@pytest.fixture
def start():
    started = []

    def start(program):
        started.append(subprocess.Popen([sys.executable, "-c", program]))
        return started[-1]

    yield start
    for process in started:
        process.kill()
        process.wait()


class Stack(StackProcesses):
    def __init__(self, processes, work_s=600.0):
        super().__init__(lambda: [process.pid for process in processes])
        self.work_s = work_s

    def is_at_work(self):
        return self.at_work(self.work_s)


@pytest.mark.parametrize("program", [BUSY, SECOND_THREAD])
def test_running_process_is_at_work_until_it_is_stopped_or_ends(start, program):
    processes = [start(IDLE), start(program)]
    both = Stack(processes)
    wait_until(both.is_at_work)
    os.kill(processes[1].pid, signal.SIGSTOP)
    wait_until(lambda: not both.is_at_work())
    os.kill(processes[1].pid, signal.SIGCONT)
    wait_until(both.is_at_work)
    processes[1].kill()
    processes[1].wait()
    assert not both.is_at_work()


def test_waiting_process_is_not_at_work(start):
    idle = Stack([start(IDLE)])
    wait_until(lambda: not idle.is_at_work())


def test_process_that_waits_for_a_disk_is_at_work(start):
    process = start(WAITS_FOR_DISK)
    waiting = Stack([process])
    wait_until(Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text)
    assert waiting.is_at_work()
    process.kill()
    process.wait()
    assert not waiting.is_at_work()


def test_process_that_had_its_time_is_not_waited_for_in_this_tick(start):
    busy = Stack([start(BUSY)], work_s=0.05)
    wait_until(busy.is_at_work)
    wait_until(lambda: not busy.is_at_work())
    busy.start_tick()
    assert busy.is_at_work()


def test_process_that_was_started_again_is_found(start, monkeypatch):
    processes = [start(IDLE)]
    found = Stack(processes)
    wait_until(lambda: not found.is_at_work())
    processes[0].kill()
    processes[0].wait()
    processes[0] = start(BUSY)
    assert not found.is_at_work()
    later_s = time.monotonic() + 10.0
    monkeypatch.setattr(time, "monotonic", lambda: later_s)
    wait_until(found.is_at_work)


def test_order_of_the_processes_is_that_of_the_messages():
    publishers = {
        "/odometry": {"/sim"},
        "/route": {"/route"},
        "/path": {"/planner"},
        "/obstacles": {"/detector"},
        "/command": {"/controller"},
        "/picture": {"/sim"},
        "/view": {"/rviz"},
    }
    subscribers = {
        "/odometry": {"/planner", "/controller", "/rviz"},
        "/route": {"/planner", "/controller"},
        "/picture": {"/detector"},
        "/obstacles": {"/planner"},
        "/path": {"/controller", "/rviz"},
        "/command": {"/sim"},
    }
    order = nodes_to(["/command"], publishers, subscribers, "/sim")
    assert sorted(order) == ["/controller", "/detector", "/planner", "/route"]
    for earlier, later in (
        ("/detector", "/planner"),
        ("/route", "/planner"),
        ("/planner", "/controller"),
    ):
        assert order.index(earlier) < order.index(later)


def test_loop_of_nodes_ends():
    publishers = {"/command": {"/a"}, "/x": {"/b"}, "/y": {"/a"}}
    subscribers = {"/x": {"/a"}, "/y": {"/b"}}
    assert nodes_to(["/command"], publishers, subscribers, "/sim") == ["/b", "/a"]
