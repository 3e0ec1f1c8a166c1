"""Real processes under a ROS master of their own, of which none may be left behind."""

import contextlib
import os
import signal
import socket
import subprocess
import time

import pytest

PATIENCE_S = 120.0
HERE = os.path.dirname(os.path.abspath(__file__))


@pytest.fixture
def route():
    """A route that is driven in half a minute of simulated time."""
    return os.path.join(HERE, "routes", "fast_bends.csv")


@pytest.fixture
def environment(tmp_path):
    """The environment of programs that belong to this test alone."""
    with own_environment(tmp_path / "ros") as variables:
        yield variables


@pytest.fixture
def other_environment(tmp_path):
    """One more, as for a second drive on this machine."""
    with own_environment(tmp_path / "other_ros") as variables:
        yield variables


@contextlib.contextmanager
def own_environment(ros_home, address="127.0.0.1"):
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    mark = f"http://{address}:{port}"
    yield {**os.environ, "ROS_MASTER_URI": mark, "ROS_IP": address, "ROS_HOME": str(ros_home)}
    left = processes_with(mark)
    for pid in left:
        os.kill(pid, signal.SIGKILL)
    assert not left, "processes were left behind"


def processes_with(mark):
    """The processes that belong to this ROS master."""
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/environ", "rb") as file:
                if f"ROS_MASTER_URI={mark}".encode() in file.read().split(b"\0"):
                    found.append(int(pid))
        except OSError:
            continue
    return [pid for pid in found if pid != os.getpid()]


class Program:
    """A program that runs beside the test; what it says can be waited for."""

    def __init__(self, command, environment, folder, log):
        self.environment = environment
        self.log = log
        with open(log, "wb") as output:
            self.process = subprocess.Popen(
                command,
                cwd=folder,
                env={**environment, "PWD": str(folder), "PYTHONUNBUFFERED": "1"},
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    @property
    def said(self):
        return self.log.read_text(errors="replace")

    def wait_to_say(self, *texts):
        """Wait until it has said all of these."""
        limit = time.monotonic() + PATIENCE_S
        while not all(text in self.said for text in texts):
            assert time.monotonic() < limit, (
                f"not said: {[text for text in texts if text not in self.said]}\n{self.said[-5000:]}"
            )
            assert self.process.poll() is None or all(text in self.said for text in texts), (
                self.said[-5000:]
            )
            time.sleep(0.05)

    def wait_for_end(self, limit_s=200.0):
        """Returns the exit status."""
        return self.process.wait(limit_s)

    def interrupt(self):
        """One Ctrl-C; returns the exit status."""
        self.process.send_signal(signal.SIGINT)
        return self.wait_for_end()

    def process_of(self, word):
        """The number of the one process of this master whose program's name holds this word."""
        found = []
        for pid in processes_with(self.environment["ROS_MASTER_URI"]):
            with contextlib.suppress(OSError), open(f"/proc/{pid}/cmdline", "rb") as file:
                parts = file.read().decode(errors="replace").split("\0")
                if any(
                    word in os.path.basename(part) for part in parts[:3]
                ) and "keep_running" not in " ".join(parts):
                    found.append(pid)
        assert len(found) == 1, f"{word}: {found}"
        return found[0]


@pytest.fixture
def start(tmp_path):
    """Starts programs; whatever still runs at the end of the test is ended."""
    programs = []

    def begin(command, environment, folder=tmp_path):
        programs.append(Program(command, environment, folder, tmp_path / f"log{len(programs)}"))
        return programs[-1]

    yield begin
    for program in programs:
        if program.process.poll() is None:
            program.interrupt()
