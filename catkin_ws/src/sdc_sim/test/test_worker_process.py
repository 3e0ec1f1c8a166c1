import os
import signal
import socket
import subprocess
import sys
import textwrap

import pytest

from sdc_sim.camera.side_process import SideProcess

DEPTH = 3


def program(body):
    """A process that serves with `work` as `body` defines it."""
    source = (
        "import sys, time, os\nfrom sdc_sim.camera.side_process import serve\n"
        + textwrap.dedent(body)
        + "\nserve(int(sys.argv[1]), work)"
    )
    return [sys.executable, "-c", source]


@pytest.fixture
def started():
    made, warnings = [], []

    def start(body):
        made.append(SideProcess(program(body), DEPTH, warnings.append))
        return made[-1], warnings

    yield start
    for process in made:
        process.close()


def writer(path):
    return f"def work(item):\n    print(*item, file=open({str(path)!r}, 'a'))"


def test_put_loses_nothing_and_keeps_the_order(started, tmp_path):
    process, warnings = started(writer(tmp_path / "done"))
    assert all(process.put([n, 0.1 * n], patience_s=30.0) for n in range(100))
    assert process.drain(30.0)
    lines = (tmp_path / "done").read_text().splitlines()
    assert [[float(word) for word in line.split()] for line in lines] == [
        [n, 0.1 * n] for n in range(100)
    ]
    assert warnings == []


def test_what_was_given_is_done_before_the_end(started, tmp_path):
    process, _ = started(writer(tmp_path / "done"))
    for n in range(DEPTH):
        process.put([n], patience_s=30.0)
    process.close()
    assert (tmp_path / "done").read_text().split() == ["0", "1", "2"]
    assert process.process.returncode == 0
    assert not process.put([3], patience_s=30.0)
    assert process.process.returncode == 0, "what was closed is not started anew"


def test_a_time_out_for_new_sockets_does_not_end_it(started, tmp_path):
    socket.setdefaulttimeout(30.0)
    try:
        process, warnings = started(writer(tmp_path / "done"))
    finally:
        socket.setdefaulttimeout(None)
    assert process.put([1], 30.0) and process.drain(30.0)
    with pytest.raises(subprocess.TimeoutExpired):
        process.process.wait(1.0)
    assert warnings == []


def test_offer_drops_while_busy(started, tmp_path):
    go = tmp_path / "go"
    process, _ = started(
        f"def work(item):\n    while not os.path.exists({str(go)!r}): time.sleep(0.01)"
    )
    assert process.offer(1)
    assert not process.offer(2)
    go.touch()
    assert process.drain(30.0)
    assert process.offer(3)


def test_who_is_too_slow_is_waited_for_once(started, tmp_path):
    go = tmp_path / "go"
    process, warnings = started(
        f"def work(item):\n    while not os.path.exists({str(go)!r}): time.sleep(0.01)"
    )
    assert [process.put(n, patience_s=0.05) for n in range(DEPTH + 3)] == [True] * DEPTH + [
        False
    ] * 3
    assert warnings == ["has not answered for 0.05 s; going on without it"]
    go.touch()
    assert process.drain(30.0)
    assert process.put(9, patience_s=30.0)


def test_a_killed_process_is_started_anew(started, tmp_path):
    process, warnings = started(writer(tmp_path / "done"))
    assert process.put([1], 30.0) and process.drain(30.0)
    first = process.process
    os.kill(first.pid, signal.SIGKILL)
    first.wait(30.0)
    assert process.put([2], 30.0) and process.drain(30.0)
    assert (tmp_path / "done").read_text().split() == ["1", "2"]
    assert warnings == ["ended with -9 and was started anew"]
