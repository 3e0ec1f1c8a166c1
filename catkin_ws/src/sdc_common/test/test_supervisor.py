"""keep_running starts what was killed again, and nothing else, and leaves nothing behind."""

import contextlib
import os
import signal
import subprocess
import sys
import time

import pytest

PATIENCE_S = 60.0
# Says its number, then does what the files in its folder tell for that number, or waits.
NODE = """
import os, signal, sys, time
folder, kept = sys.argv[1], os.environ["NODE_STATE_FOLDER"]
count = len(os.listdir(kept)) + 1
open(os.path.join(kept, f"start{count}"), "w").close()
for name, code in (("int", None), ("term", None)):
    signal.signal(getattr(signal, "SIG" + name.upper()), lambda number, frame: sys.exit(40 + number))
with open(os.path.join(folder, "said"), "a") as said:
    said.write(f"{os.getpid()} {kept}\\n")
deed = sys.argv[1 + count] if len(sys.argv) > 1 + count else "wait"
if deed.startswith("exit"):
    sys.exit(int(deed[4:]))
if deed.startswith("kill"):
    os.kill(os.getpid(), int(deed[4:]))
time.sleep(600)
"""


@pytest.fixture
def keep(tmp_path):
    processes = []

    def start(*deeds):
        command = [
            sys.executable,
            "-m",
            "sdc_common.ros.supervisor",
            sys.executable,
            "-c",
            NODE,
            str(tmp_path),
            *deeds,
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
    """(pid, folder) of each start, once there are `count`."""
    limit = time.monotonic() + PATIENCE_S
    while True:
        with contextlib.suppress(FileNotFoundError):
            lines = (tmp_path / "said").read_text().splitlines()
            if len(lines) >= count:
                return [(int(pid), folder) for pid, folder in map(str.split, lines)]
        assert time.monotonic() < limit
        time.sleep(0.02)


@pytest.mark.parametrize("code", [0, 1, 3])
def test_an_end_of_its_own_is_passed_on(keep, tmp_path, code):
    process = keep(f"exit{code}")
    assert process.wait(PATIENCE_S) == code
    ((_, folder),) = starts(tmp_path, 1)
    assert not os.path.exists(folder)


def test_a_killed_node_is_started_again_and_finds_its_folder(keep, tmp_path):
    process = keep("kill9", "kill11", "exit7")
    assert process.wait(PATIENCE_S) == 7
    said = process.stderr.read()
    assert "dummy was killed by SIGKILL; starting it again" in said
    assert "dummy was killed by SIGSEGV; starting it again" in said
    (_, first), (_, second), (_, third) = starts(tmp_path, 3)
    assert first == second == third
    assert not os.path.exists(first)


def test_a_node_that_dies_at_once_is_given_up(keep, tmp_path):
    process = keep(*["kill9"] * 50)
    assert process.wait(PATIENCE_S) == 128 + 9
    assert "5 times at once, giving up" in process.stderr.read()
    assert len(starts(tmp_path, 5)) == 5


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_a_request_to_end_reaches_the_node_and_ends_both(keep, tmp_path, sent):
    process = keep()
    ((pid, folder),) = starts(tmp_path, 1)
    process.send_signal(sent)
    assert process.wait(PATIENCE_S) == 40 + sent
    assert not os.path.exists(f"/proc/{pid}")
    assert not os.path.exists(folder)


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_a_node_that_a_request_killed_stays_ended(keep, sent):
    assert keep(f"kill{int(sent)}").wait(PATIENCE_S) == 40 + sent


def test_no_orphan_is_left_when_the_keeper_is_killed(keep, tmp_path):
    process = keep()
    ((pid, _),) = starts(tmp_path, 1)
    process.kill()
    limit = time.monotonic() + PATIENCE_S
    while _runs(pid):
        assert time.monotonic() < limit
        time.sleep(0.02)


def _runs(pid):
    with contextlib.suppress(OSError), open(f"/proc/{pid}/stat", encoding="ascii") as file:
        return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    return False
