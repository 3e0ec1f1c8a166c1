"""The supervisor in this process, with nodes that are functions in forks of it."""

import ctypes
import itertools
import json
import os
import shutil
import signal
import sys
import tempfile
import types
from pathlib import Path

import pytest

from sdc_common.ros import supervisor
from sdc_common.ros.supervisor import END_SIGNALS, STATE_FOLDER_VARIABLE, supervise

BROKEN = 99
GET_DEATH_SIGNAL = 2  # of prctl


def kill_own(process, number, kill=os.kill):
    """Send a signal to a process of this test."""
    assert process > 1, "that is a group of processes, or the first process of the machine"
    kill(process, number)


@pytest.fixture(autouse=True)
def kept(monkeypatch, tmp_path):
    """Restore what the supervisor changes in its process; return the folder of its files."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    monkeypatch.setattr(sys, "argv", ["/scripts/planner.py", "_gain:=2", "__name:=dummy"])
    monkeypatch.delenv(STATE_FOLDER_VARIABLE, raising=False)
    monkeypatch.setattr(os, "kill", kill_own)
    handlers = {number: signal.getsignal(number) for number in END_SIGNALS}
    process_name = Path("/proc/self/comm").read_text()
    yield folder
    Path("/proc/self/comm").write_text(process_name)
    for number, handler in handlers.items():
        signal.signal(number, handler)


def run(node):
    """Supervise a node.

    Args:
        node: function of the number of this start, from 1, that returns the exit code

    Returns:
        the exit status of the supervisor; None: `supervise` returned in this process
    """
    process, code = os.getpid(), BROKEN
    try:
        supervise()
        if os.getpid() != process:
            folder = Path(os.environ[STATE_FOLDER_VARIABLE])
            start = len(list(folder.iterdir())) + 1
            (folder / str(start)).touch()
            code = node(start)
    except SystemExit as end:
        return end.code
    finally:
        if os.getpid() != process:
            os._exit(code)
    return None


def die(number=signal.SIGKILL):
    os.kill(os.getpid(), number)


def request_end(number):
    """Ask the supervisor to end, and wait until it passes that on."""
    os.kill(os.getppid(), number)
    signal.alarm(20)
    signal.pause()


@pytest.mark.parametrize("code", [0, 1, 3])
def test_exit_code_of_the_node_is_that_of_the_supervisor(kept, capsys, code):
    assert run(lambda start: code) == code
    assert list(kept.iterdir()) == []
    assert capsys.readouterr().err == ""


def test_killed_node_is_started_again_with_the_same_folder(kept, capsys):
    signals = [signal.SIGKILL, signal.SIGUSR1]
    assert run(lambda start: die(signals[start - 1]) if start < 3 else 7) == 7
    assert capsys.readouterr().err == (
        "supervisor: dummy was killed by SIGKILL; restarting\n"
        "supervisor: dummy was killed by SIGUSR1; restarting\n"
    )
    assert list(kept.iterdir()) == []


def test_node_without_a_given_name_has_that_of_its_script(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["/scripts/planner.py", "_gain:=2"])
    assert run(lambda start: die() if start == 1 else 0) == 0
    assert "supervisor: planner.py was killed" in capsys.readouterr().err


def test_node_that_crashes_five_times_in_a_row_is_given_up(kept, capsys):
    assert run(lambda start: die() if start < 8 else 0) == 128 + signal.SIGKILL
    *restarts, last = capsys.readouterr().err.splitlines()
    assert len(restarts) == 4
    assert last.endswith("SIGKILL; giving up after 5 crashes in a row")
    assert list(kept.iterdir()) == []


def times_of_runs(durations):
    now = 1000.0
    for duration in durations:
        yield now
        now += duration
        yield now


@pytest.mark.parametrize(("duration_s", "starts"), [(9.9, 5), (10.0, 10)])
def test_crash_long_after_the_start_begins_a_new_row(monkeypatch, capsys, duration_s, starts):
    times = times_of_runs(itertools.chain([1.0] * 4, [duration_s], itertools.repeat(1.0)))
    monkeypatch.setattr(supervisor, "time", types.SimpleNamespace(monotonic=times.__next__))
    assert run(lambda start: die()) == 128 + signal.SIGKILL
    assert len(capsys.readouterr().err.splitlines()) == starts


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_node_that_an_end_signal_killed_is_not_started_again(capsys, number):
    assert run(lambda start: die(number)) == 128 + number
    assert capsys.readouterr().err == ""


def test_interrupt_of_the_node_raises_keyboard_interrupt():
    def node(start):
        try:
            die(signal.SIGINT)
        except KeyboardInterrupt:
            return 5

    assert run(node) == 5


@pytest.mark.parametrize("number", END_SIGNALS)
def test_request_to_end_is_passed_on_to_the_node(number):
    def node(start):
        signal.signal(number, lambda *_: os._exit(40 + start))
        request_end(number)

    assert run(node) == 41


def test_node_that_crashes_at_its_end_is_not_started_again(capsys):
    def node(start):
        signal.signal(signal.SIGTERM, lambda *_: die())
        request_end(signal.SIGTERM)

    assert run(node) == 128 + signal.SIGKILL
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("start_of_request", [1, 2])
def test_request_to_end_before_a_start_ends_the_node_that_starts(
    monkeypatch, number, start_of_request
):
    # The supervisor looks at the clock before a start and after a crash.
    looks = itertools.count(1)

    def now():
        if next(looks) == 2 * start_of_request - 1:
            os.kill(os.getpid(), number)
        return 0.0

    def node(start):
        if start < start_of_request:
            die()
        signal.alarm(20)
        signal.pause()

    monkeypatch.setattr(supervisor, "time", types.SimpleNamespace(monotonic=now))
    assert run(node) == 128 + number


def test_node_can_remove_the_folder_itself(kept):
    def node(start):
        shutil.rmtree(os.environ[STATE_FOLDER_VARIABLE])
        return 3

    assert run(node) == 3
    assert list(kept.iterdir()) == []


def test_node_has_its_own_session_and_name_and_ends_with_the_supervisor(monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "argv", ["planner.py", "__name:=a_node_with_a_long_name"])

    def node(start):
        death_signal = ctypes.c_int()
        ctypes.CDLL(None).prctl(GET_DEATH_SIGNAL, ctypes.byref(death_signal))
        facts = {
            "leads its session": os.getsid(0) == os.getpid(),
            "name": Path("/proc/self/comm").read_text(),
            "name of the supervisor": Path(f"/proc/{os.getppid()}/comm").read_text(),
            "signal at the supervisor's death": death_signal.value,
            "folder": Path(os.environ[STATE_FOLDER_VARIABLE]).name.partition("-")[0],
            "blocked signals": len(signal.pthread_sigmask(signal.SIG_BLOCK, ())),
        }
        (tmp_path / "facts").write_text(json.dumps(facts))
        return 0

    assert run(node) == 0
    assert json.loads((tmp_path / "facts").read_text()) == {
        "leads its session": True,
        "name": "a_node_with_a_l\n",
        "name of the supervisor": "supervisor\n",
        "signal at the supervisor's death": signal.SIGKILL,
        "folder": "supervisor",
        "blocked signals": 0,
    }


def test_node_that_is_supervised_already_gets_no_supervisor(monkeypatch, tmp_path):
    monkeypatch.setenv(STATE_FOLDER_VARIABLE, str(tmp_path))
    assert run(lambda start: 0) is None
