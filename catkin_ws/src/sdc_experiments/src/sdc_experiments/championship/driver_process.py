"""Drivers in processes of their own: start them in a sandbox, ask them, and measure their time."""

from __future__ import annotations

import contextlib
import os
import pickle
import re
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path as FilePath
from typing import Any, Sequence

from sdc_common.configuration import package_folder
from sdc_common.driving import Command, Observation, Path
from sdc_experiments.championship.host import (
    ANSWER,
    FULL,
    HELLO,
    MAX_MESSAGE,
    READY,
    REFUSALS,
    REFUSED,
)
from sdc_experiments.championship.mission import DriverMission
from sdc_experiments.sandbox import (
    USER_IDS,
    SandboxError,
    as_user,
    bound,
    identity,
    seccomp_module,
    system,
)
from sdc_map.sumo_programs import maps_folder

MAX_SOURCE = 200_000  # bytes
_MAX_SLEEP_S = 2.0  # a drive ends when its driver sleeps for longer
_MAX_STEP_S = 5.0  # a drive ends when its driver computes an answer for longer
_START_S = 60.0  # processor time to load the file and to make the first calls
# Wall time to wait for a process that neither computes nor ends, also on a busy machine [s].
_MAX_WALL_S = 300.0
_POLL_S = 0.01
_KEPT = ("LANG", "PATH", "ROS_PACKAGE_PATH", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
_PACKAGES = ("sdc_common", "sdc_map", "sdc_sim", "sdc_package", "sdc_experiments", "sdc_mpc")
# By the status of the process, or by the name of the signal that ended it.
_ENDS = {
    "SIGSYS": "it called the system for what is forbidden: a program, thread or socket",
    "SIGXCPU": "it used up its memory or processor time",
    "SIGKILL": "it used up its memory or processor time",
    0: "it exited early",
    FULL: "it was refused something when its output was full",
}


class DriverError(Exception):
    """The end of a driver before the end of its drive; the message is one line."""


class DriverServer:
    """Loads the library in a sandbox, and starts a process for each drive.

    Without the sandbox of bubblewrap, all other limits remain.

    Raises:
        SandboxError: there is no sandbox on this machine
    """

    def __init__(self, source: str, sandboxed: bool = True):
        if not sys.platform.startswith("linux"):
            raise SandboxError("drivers run in processes of their own, which need Linux")
        self._control, driver_end = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        command = [sys.executable, "-B", "-m", "sdc_experiments.championship.host"]
        command.append(str(driver_end.fileno()))
        environment = {name: os.environ[name] for name in _KEPT if name in os.environ}
        environment.update(PYTHONHASHSEED="0", HOME="/tmp")
        environment["PYTHONPATH"] = os.pathsep.join(_libraries())
        if sandboxed:
            command = _in_sandbox(command)
        with driver_end:
            self._process = subprocess.Popen(
                command,
                env=environment,
                pass_fds=[driver_end.fileno()],
                stdin=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
            )
        try:
            self._control.settimeout(_MAX_WALL_S)
            self._control.send(source.encode())
            if self._control.recv(16) == READY:
                return
        except OSError:
            self._process.kill()
        seen = (self._process.communicate()[1].decode().strip().splitlines() or ["it ended"])[-1]
        raise SandboxError(f"no sandbox for drivers: {seen}; sandbox:=false drives without one")

    def __enter__(self) -> DriverServer:
        return self

    def __exit__(self, *_error: object) -> None:
        self._control.close()
        self._process.kill()
        self._process.communicate()

    def start(self, mission: DriverMission) -> DriverProcess:
        """Start the driver of a drive; see DriverProcess."""
        return DriverProcess(self._control, mission)


class DriverProcess:
    """The driver of one drive, as the software of a car.

    Attributes:
        path: the start of the path that it follows, None if it is unknown
        reason: what limited its speed, "" if unknown
        spent_ns: processor time of the last step [ns]

    Raises:
        DriverError: the file cannot be loaded
    """

    def __init__(self, control: socket.socket, mission: DriverMission):
        self.path: Path | None = None
        self.reason = ""
        self.spent_ns = self._clock = self._used_ns = 0
        self._control, self._slept_s, self._pidfd = control, 0.0, -1
        self._status = 0
        self._link, driver_end = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._link.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 1)
        self._log: Any = tempfile.TemporaryFile()  # noqa: SIM115  it is closed with the drive
        message = b""
        with driver_end, contextlib.suppress(OSError):
            socket.send_fds(control, [b"drive"], [driver_end.fileno(), self._log.fileno()])
            driver_end.close()
            self._link.settimeout(_MAX_WALL_S)
            message, ancillary, _, _ = self._link.recvmsg(16, socket.CMSG_SPACE(12))
        if message != HELLO:
            control.close()  # no other drive waits for it
            raise DriverError("the process that starts it has stopped")
        self._link.settimeout(None)
        # The number of the process outside of its sandbox.
        number = int.from_bytes(ancillary[0][2][:4], "little")
        self._clock, self._pidfd = (~number << 3) | 2, os.pidfd_open(number)
        self._status_file = FilePath(f"/proc/{number}/stat")
        self._send(pickle.dumps(mission))
        if self._answer(_START_S) != READY:
            raise self._error("it answered before the first observation")
        self._slept_s, self._used_ns = 0.0, self._clock_ns()

    def step(self, observation: Observation) -> Command | None:
        """Return the driver's answer; `spent_ns` is the processor time since the last one.

        Raises:
            DriverError: the driver has ended, or does not answer
        """
        if select.select([self._link], [], [], 0.0)[0]:
            text = "it wrote to the socket of its answers"
            raise self._error(text if self._link.recv(1) else "")
        self._send(pickle.dumps(observation))
        message = self._answer(_MAX_STEP_S)
        used_ns = self._clock_ns()
        self.spent_ns, self._used_ns = used_ns - self._used_ns, used_ns
        if len(message) < ANSWER.size:
            raise self._error("it wrote to the socket of its answers")
        has_command, throttle, steer, brake, hand_brake, reverse, planned = ANSWER.unpack(
            message[: ANSWER.size]
        )
        self.reason = message[ANSWER.size :].decode(errors="replace")
        self.path = Path(((0.0, 0.0, planned),)) if planned == planned else None
        if not has_command:
            return None
        try:
            return Command(throttle, steer, brake, hand_brake, reverse).clamped()[0]
        except ValueError as error:
            raise self._error(str(error)) from None

    def close(self) -> list[str]:
        """End the process, and return what it was refused."""
        if self._pidfd >= 0:
            with contextlib.suppress(OSError):
                signal.pidfd_send_signal(self._pidfd, signal.SIGKILL)
            os.close(self._pidfd)
            self._pidfd = -1
            try:
                self._status = int.from_bytes(self._control.recv(4), "little", signed=True)
            except OSError:
                self._control.close()
        self._link.close()
        # The first line of each kind: a driver can print others, but none that push out these.
        lines = self.output().splitlines()[::-1]
        kinds = [f"{REFUSED} {kind}" for kind in REFUSALS]
        found = {kind: line[:200] for line in lines for kind in kinds if line.startswith(kind)}
        return sorted(found.values())

    def output(self) -> str:
        """Return what it has printed."""
        self._log.seek(0)
        return re.sub(r"[^\n -~]", "?", self._log.read().decode(errors="replace"))

    def _send(self, message: bytes) -> None:
        with contextlib.suppress(ConnectionError):
            self._link.send(message)

    def _answer(self, longest_s: float) -> bytes:
        """Return the next message, within a limit of the processor time [s]."""
        until_s = time.monotonic() + _MAX_WALL_S
        while not select.select([self._link], [], [], _POLL_S)[0]:
            if 1e-9 * (self._clock_ns() - self._used_ns) > longest_s:
                raise self._error(f"it computed for more than {longest_s:g} s")
            self._slept_s += _POLL_S if self._sleeps() else 0.0
            if self._slept_s > _MAX_SLEEP_S:
                raise self._error(f"it slept for more than {_MAX_SLEEP_S:g} s")
            if time.monotonic() > until_s:
                raise self._error(f"it did not answer within {_MAX_WALL_S:g} s")
        message = b""
        with contextlib.suppress(ConnectionError):
            message = self._link.recv(MAX_MESSAGE)
        if not message:
            raise self._error("")
        return message

    def _clock_ns(self) -> int:
        """Return the processor time of all that the process has done, as its kernel counts it."""
        try:
            return time.clock_gettime_ns(self._clock)
        except OSError:  # it has ended
            return self._used_ns

    def _sleeps(self) -> bool:
        """Return whether it neither computes nor waits for a core, and has not answered.

        A process can also stop itself.
        """
        with contextlib.suppress(OSError):
            state = self._status_file.read_text().rpartition(")")[2].split()[0]
            return state != "R" and not select.select([self._link], [], [], 0.0)[0]
        return False

    def _error(self, text: str) -> DriverError:
        """End the process; return what ended it: a text, or how it exited."""
        self.close()
        if not text:
            last = (self.output().strip().splitlines() or [""])[-1]
            status = self._status
            end = signal.Signals(-status).name if status < 0 else status
            text = _ENDS.get(end, last or f"it ended with status {status}")
        return DriverError(text[:200])


def _libraries() -> list[str]:
    """Return the folders of Python modules, without the one of the command or of a test."""
    folders = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    # A virtual environment, and the Python that it is made of.
    folders += [folder for folder in (sys.prefix, sys.base_prefix) if folder != "/usr"]
    return [os.path.realpath(folder) for folder in folders if folder and os.path.isdir(folder)]


def sandbox_problem() -> str:
    """Return what the sandbox lacks on this machine, "" if it is installed."""
    if shutil.which("bwrap") is None:
        return "bwrap is not installed"
    return "" if seccomp_module() else "the Python module seccomp is missing"


def _in_sandbox(command: Sequence[str]) -> list[str]:
    """Return the command line that runs a command in the sandbox, without any file to write."""
    if problem := sandbox_problem():
        raise SandboxError(f"no sandbox for drivers: {problem}; sandbox:=false drives without one")
    packages = [package_folder(name) for name in _PACKAGES]
    folders = [*_libraries(), *map(os.path.realpath, packages), maps_folder()]
    return [
        *system(),
        "--unshare-net",
        *bound("--ro-bind-try", *dict.fromkeys(folders)),
        *identity(),
        *(word for name in ("/tmp", "/dev/shm", "/dev", "/") for word in ("--remount-ro", name)),
        *("--chdir", "/", "--"),
        *as_user(USER_IDS[os.getpid() % len(USER_IDS)]),
        *command,
    ]
