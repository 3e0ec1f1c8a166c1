"""The supervisor restarts a node that a signal killed, and passes its own exit on."""

import contextlib
import os
import signal
import subprocess
import sys
import time

import pytest

TIMEOUT_S = 60.0
# Log the start, then do what the command line asks of this start, or wait.
NODE = """
import os, signal, sys, time
from sdc_common.ros.supervisor import supervise
supervise()
folder, kept = sys.argv[1], os.environ["NODE_STATE_FOLDER"]
count = len(os.listdir(kept)) + 1
open(os.path.join(kept, f"start{count}"), "w").close()
for name, code in (("int", None), ("term", None)):
    signal.signal(getattr(signal, "SIG" + name.upper()), lambda number, frame: sys.exit(40 +
    number))
with open(os.path.join(folder, "starts"), "a") as log:
    log.write(f"{os.getpid()} {kept}\\n")
action = sys.argv[1 + count] if len(sys.argv) > 1 + count else "wait"
if action.startswith("exit"):
    sys.exit(int(action[4:]))
if action.startswith("kill"):
    os.kill(os.getpid(), int(action[4:]))
time.sleep(600)
"""


@pytest.fixture
def supervised(tmp_path):
    processes = []

    def start(*actions):
        command = [
            sys.executable,
            "-c",
            NODE,
            str(tmp_path),
            *actions,
            "__name:=dummy",
        ]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        processes.append(process)
        return process

    yield start
    for process in processes:
        process.kill()
        process.wait()
        process.stderr.close()


def starts(tmp_path, count):
    """Return (pid, folder) of each start, once there are `count`."""
    limit = time.monotonic() + TIMEOUT_S
    while True:
        with contextlib.suppress(FileNotFoundError):
            lines = (tmp_path / "starts").read_text().splitlines()
            if len(lines) >= count:
                return [(int(pid), folder) for pid, folder in map(str.split, lines)]
        assert time.monotonic() < limit
        time.sleep(0.02)


@pytest.mark.parametrize("code", [0, 1, 3])
def test_exit_code_of_the_node_is_passed_on(supervised, tmp_path, code):
    process = supervised(f"exit{code}")
    assert process.wait(TIMEOUT_S) == code
    ((_, folder),) = starts(tmp_path, 1)
    assert not os.path.exists(folder)


def test_killed_node_is_restarted_with_the_same_state_folder(supervised, tmp_path):
    process = supervised("kill9", "kill11", "exit7")
    assert process.wait(TIMEOUT_S) == 7
    log = process.stderr.read()
    assert "dummy was killed by SIGKILL; restarting" in log
    assert "dummy was killed by SIGSEGV; restarting" in log
    (_, first), (_, second), (_, third) = starts(tmp_path, 3)
    assert first == second == third
    assert not os.path.exists(first)


def test_node_that_crashes_at_once_is_given_up(supervised, tmp_path):
    process = supervised(*["kill9"] * 50)
    assert process.wait(TIMEOUT_S) == 128 + 9
    assert "giving up after 5 crashes in a row" in process.stderr.read()
    assert len(starts(tmp_path, 5)) == 5


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_request_to_end_reaches_the_node_and_ends_both(supervised, tmp_path, sent):
    process = supervised()
    ((pid, folder),) = starts(tmp_path, 1)
    process.send_signal(sent)
    assert process.wait(TIMEOUT_S) == 40 + sent
    assert not os.path.exists(f"/proc/{pid}")
    assert not os.path.exists(folder)


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_node_that_an_end_signal_killed_is_not_restarted(supervised, sent):
    assert supervised(f"kill{int(sent)}").wait(TIMEOUT_S) == 40 + sent


def test_node_is_killed_with_its_supervisor(supervised, tmp_path):
    process = supervised()
    ((pid, _),) = starts(tmp_path, 1)
    process.kill()
    limit = time.monotonic() + TIMEOUT_S
    while _runs(pid):
        assert time.monotonic() < limit
        time.sleep(0.02)


def _runs(pid):
    with contextlib.suppress(OSError), open(f"/proc/{pid}/stat", encoding="ascii") as file:
        return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    return False
