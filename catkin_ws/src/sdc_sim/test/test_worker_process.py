"""Worker process: order, back-pressure, restart, and its end."""

import os
import re
import signal
import socket
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from sdc_sim.camera import worker_process
from sdc_sim.camera.worker_process import WorkerProcess

FOLDER = os.path.dirname(__file__)
sys.path.insert(0, FOLDER)  # the worker gets the path of the caller

from worker_handlers import make_after, make_stage, make_waiter, make_writer  # noqa: E402

DEPTH = 3
LIMIT_S = 30.0


def wait_until(condition, what):
    deadline = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline, f"no {what} within {LIMIT_S:g} s"
        time.sleep(0.01)


def lines_of(path):
    return path.read_text(encoding="utf-8").splitlines() if path.exists() else []


def is_running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


@pytest.fixture
def start():
    made = []

    def start_worker(make_handler, path, **options):
        warnings = []
        made.append(WorkerProcess(make_handler, (str(path),), DEPTH, warnings.append, **options))
        return made[-1], warnings

    yield start_worker
    for worker in made:
        worker.close()


def test_put_loses_nothing_and_keeps_the_order(start, tmp_path):
    worker, warnings = start(make_writer, tmp_path / "done")
    assert all(worker.put((n, 0.1 * n), LIMIT_S) for n in range(100))
    worker.close()
    assert lines_of(tmp_path / "done") == [f"{n} {0.1 * n}" for n in range(100)]
    assert warnings == []


def test_close_finishes_the_items_that_were_sent(start, tmp_path):
    worker, warnings = start(make_writer, tmp_path / "done")
    for n in range(DEPTH):
        assert worker.put((n,), LIMIT_S)
    worker.close()
    assert lines_of(tmp_path / "done") == ["0", "1", "2"]
    assert worker.process.exitcode == 0
    assert not worker.put((3,), LIMIT_S) and not worker.offer((3,))
    assert worker.process.exitcode == 0 and warnings == [], "a closed worker is not restarted"


def test_worker_finishes_and_ends_its_own_worker(start, tmp_path):
    worker, warnings = start(make_stage, tmp_path / "done")
    assert all(worker.put((n,), LIMIT_S) for n in range(20))
    worker.close()
    assert lines_of(tmp_path / "done") == [str(n) for n in range(20)]
    assert worker.process.exitcode == 0 and warnings == []


def test_worker_survives_a_default_timeout_of_sockets(start, tmp_path):
    socket.setdefaulttimeout(0.5)  # rospy sets one, too
    try:
        worker, warnings = start(make_writer, tmp_path / "done")
    finally:
        socket.setdefaulttimeout(None)
    assert worker.put((1,), LIMIT_S)
    wait_until(lambda: lines_of(tmp_path / "done"), "item")
    worker.process.join(1.0)
    assert worker.process.is_alive()
    assert worker.put((2,), LIMIT_S)
    worker.close()
    assert lines_of(tmp_path / "done") == ["1", "2"] and warnings == []


def test_offer_drops_items_while_the_worker_is_busy(start, tmp_path):
    worker, _ = start(make_waiter, tmp_path / "go")
    wait_until(lambda: worker.offer(1), "start")
    assert not worker.offer(2)
    (tmp_path / "go").touch()
    wait_until(lambda: worker.offer(3), "room")


def test_slow_start_is_waited_for_once(start, tmp_path, monkeypatch):
    monkeypatch.setattr(worker_process, "_START_TIMEOUT_S", 0.5)
    worker, warnings = start(make_after, tmp_path / "go")
    assert not worker.offer(0), "real time does not queue items for the start"
    assert [worker.put(n, LIMIT_S) for n in range(DEPTH + 1)] == [True] * (DEPTH - 1) + [False] * 2
    assert warnings == ["did not start within 0.5 s; items are dropped"]
    (tmp_path / "go").touch()
    wait_until(lambda: worker.offer(0), "start")


def test_slow_worker_is_waited_for_once(start, tmp_path):
    worker, warnings = start(make_waiter, tmp_path / "go")
    sent = [worker.put(n, 0.5) for n in range(DEPTH + 1)]
    begin = time.monotonic()
    sent += [worker.put(n, LIMIT_S) for n in range(2)]
    assert time.monotonic() - begin < 0.5 * LIMIT_S
    assert sent == [True] * DEPTH + [False] * 3
    assert warnings == ["did not finish an item within 0.5 s; items are dropped"]
    (tmp_path / "go").touch()
    wait_until(lambda: worker.put(9, 0.0), "room")
    assert all(worker.put(n, LIMIT_S) for n in range(20)), "it is waited for again"
    assert len(warnings) == 1


@pytest.mark.parametrize("send", [WorkerProcess.offer, partial(WorkerProcess.put, timeout_s=30.0)])
def test_killed_worker_is_restarted_with_a_warning(start, tmp_path, send):
    worker, warnings = start(make_writer, tmp_path / "done")
    wait_until(lambda: send(worker, (1,)), "start")
    wait_until(lambda: lines_of(tmp_path / "done"), "item")
    first = worker.process
    os.kill(first.pid, signal.SIGKILL)
    first.join(LIMIT_S)
    assert send(worker, (2,))
    worker.close()
    assert worker.process.pid != first.pid
    assert lines_of(tmp_path / "done") == ["1", "2"]
    assert warnings == ["ended with exit code -9; restarting it"]


def test_sigint_does_not_end_the_worker(start, tmp_path):
    worker, warnings = start(make_writer, tmp_path / "done")
    os.kill(worker.process.pid, signal.SIGINT)  # while it starts
    assert worker.put((1,), LIMIT_S)
    wait_until(lambda: lines_of(tmp_path / "done"), "item")
    os.kill(worker.process.pid, signal.SIGINT)
    assert worker.put((2,), LIMIT_S)
    worker.close()
    assert lines_of(tmp_path / "done") == ["1", "2"] and warnings == []


@pytest.mark.parametrize(("idle", "policy"), [(True, os.SCHED_IDLE), (False, os.SCHED_OTHER)])
def test_worker_has_a_priority_and_a_session_of_its_own(start, tmp_path, idle, policy):
    worker, _ = start(make_writer, tmp_path / "done", idle=idle)
    assert worker.put((1,), LIMIT_S)
    wait_until(lambda: lines_of(tmp_path / "done"), "item")
    pid = worker.process.pid
    assert os.sched_getscheduler(pid) == policy
    assert os.getsid(pid) == pid


@pytest.mark.parametrize("handler", ["make_writer", "never_start"])
def test_worker_ends_when_its_caller_is_killed(handler, tmp_path):
    script = tmp_path / "caller.py"
    script.write_text(
        f"""
import multiprocessing, os, sys, time
sys.path.insert(0, {FOLDER!r})
from worker_handlers import {handler}
from sdc_sim.camera.worker_process import WorkerProcess

if __name__ == "__main__":
    # All shared files of this process and its children have its number in their names.
    multiprocessing.current_process()._config["semprefix"] = f"/{{os.getpid()}}"
    worker = WorkerProcess({handler}, (sys.argv[1],), 3, print)
    worker.put((worker.process.pid,), 30.0)
    time.sleep(60.0)
""",
        encoding="utf-8",
    )
    with subprocess.Popen([sys.executable, script, tmp_path / "done"]) as caller:
        wait_until(lambda: lines_of(tmp_path / "done"), "item")
        caller.kill()
    (pid,) = map(int, lines_of(tmp_path / "done"))
    wait_until(lambda: not is_running(pid), "end of the worker")
    left = [name for name in os.listdir("/dev/shm") if re.search(f"{caller.pid}|{pid}", name)]
    assert left == []
