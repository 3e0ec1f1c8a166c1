"""Run a student's programs: start them, watch them, and end them with all that they started.

Such a program may crash, loop for ever, start other programs, or wait for ever; the check goes on.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import threading
import time
from pathlib import Path
from typing import Callable, Iterable, Sequence

import psutil

from sdc_common.processes import matching

# An environment variable that marks all processes a program starts, whatever their process group.
MARK = "SDC_WORKSHOP_EXAM"

IDLE_S = 0.8
_POLL_S = 0.02
# On a busy machine the check itself may wait for a processor, so that time alone is no measure.
_IDLE_POLLS = 30
# CPU time that a program which only waits may use in this window (timers, rospy's threads) [s].
_IDLE_CPU_S = 0.04
# CPU time within which a node answers a picture or a path [s].
BUSY_CPU_S = 3.0
TIMEOUT_S = 60.0
_END_TIMEOUT_S = 30.0
_MAX_OUTPUT = 200_000
_RUNNING = (psutil.STATUS_RUNNING, psutil.STATUS_DISK_SLEEP)


class NotJudged(Exception):
    """The machine is too busy to tell whether a program is right."""


class Program:
    """A running program and its output. The end of the `with` block ends it.

    Attributes:
        command: the command line
        mark: identifies the processes that it starts
        watch: ends after the program, or None
        killed: whether the check has ended it
    """

    watch: threading.Thread | None = None
    killed = False

    def __init__(
        self,
        command: Sequence[object],
        environment: dict,
        folder: Path | None = None,
        stdin: socket.socket | None = None,
    ):
        self.command = [str(word) for word in command]
        self.mark = f"{os.getpid()}-{time.monotonic_ns()}"
        self._pieces: list[bytes] = []
        self._size = 0
        self._main: psutil.Process | None = None
        self._process = subprocess.Popen(
            self.command,
            env={**environment, MARK: f"{os.environ.get(MARK, '')}/{self.mark}"},
            cwd=folder,
            stdin=stdin or subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def __enter__(self) -> Program:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def _read(self) -> None:
        with self._process.stdout as pipe:
            for piece in iter(lambda: pipe.read1(65536), b""):
                if self._size < _MAX_OUTPUT:
                    self._pieces.append(piece)
                    self._size += len(piece)

    @property
    def process_id(self) -> int:
        """Its process id."""
        return self._process.pid

    @property
    def output(self) -> str:
        """What it has printed until now, on standard output and standard error."""
        return b"".join(self._pieces).decode(errors="replace")

    @property
    def status(self) -> int | None:
        """Its exit status; None while it runs."""
        return self._process.poll()

    def wait_until(
        self,
        condition: Callable[[], object],
        timeout_s: float = TIMEOUT_S,
        most_cpu_s: float = BUSY_CPU_S,
    ) -> str:
        """Wait until `condition()` is true, or will not become true any more.

        Returns:
            "true", "ended" (the program has ended), "idle" (it waits for something) or "busy" (it
            used more than `most_cpu_s`)

        Raises:
            NotJudged: none of these until the timeout
        """
        limit = time.monotonic() + timeout_s
        cpu_at_start, _ = self.activity()
        idle_since, idle_cpu, polls = time.monotonic(), cpu_at_start, 0
        while True:
            if condition():
                return "true"
            if self.status is not None:
                self._reader.join(timeout=2.0)
                return "true" if condition() else "ended"
            time.sleep(_POLL_S)
            now, (cpu, running) = time.monotonic(), self.activity()
            polls += 1
            if running or cpu - idle_cpu > _IDLE_CPU_S:
                idle_since, idle_cpu, polls = now, cpu, 0
            if now - idle_since >= IDLE_S and polls >= _IDLE_POLLS:
                return "true" if condition() else "idle"
            if cpu - cpu_at_start > most_cpu_s:
                return "busy"
            if now > limit + self.waited_s:
                raise NotJudged

    def wait(self, timeout_s: float = TIMEOUT_S) -> int | None:
        """Return its exit status if it ends in time, else None; half of the time is to compute.

        While it has got less of a processor, with all that it has started, it has twice the time.

        Raises:
            NotJudged: it still computes at the end of that time
        """
        limit = time.monotonic() + timeout_s
        while self.status is None and self.activity()[0] < 0.5 * timeout_s:
            late_s = time.monotonic() - limit - self.waited_s
            if late_s > 0.0:
                cpu_s, running = self.activity(of_all=True)
                if not running or cpu_s >= 0.5 * timeout_s:
                    break
                if late_s > timeout_s:
                    raise NotJudged
            time.sleep(_POLL_S)
        if self.status is not None:
            self._reader.join(timeout=2.0)
        return self.status

    @property
    def main(self) -> psutil.Process:
        """The process of the program itself, which sh and bwrap start in a sandbox."""
        if self._main is None:
            found = first = psutil.Process(self._process.pid)
            while found.name() == "bwrap" or (found == first and self.command[0] == "sh"):
                children = found.children()
                if not children:
                    return found
                found = children[0]
            self._main = found
        return self._main

    @property
    def waited_s(self) -> float:
        """How long it has waited for a processor: on a busy machine, no time of its own [s]."""
        with contextlib.suppress(psutil.Error, OSError):
            numbers = Path(f"/proc/{self.main.pid}/schedstat").read_text(encoding="ascii").split()
            return 1e-9 * int(numbers[1])
        return 0.0

    def activity(self, of_all: bool = False) -> tuple:
        """Return its CPU time [s], and whether it runs or waits for a processor or a disk.

        With `of_all`, also of the processes that it has started.
        """
        total_s, running = 0.0, False
        with contextlib.suppress(psutil.Error):
            for process in (self.main, *(self.main.children(recursive=True) if of_all else ())):
                with contextlib.suppress(psutil.NoSuchProcess):
                    total_s += sum(process.cpu_times()[:2])
                    running = running or process.status() in _RUNNING
        return total_s, running

    def interrupt(self) -> None:
        """Send what Ctrl-C sends."""
        self._signal_group(signal.SIGINT)

    def kill(self) -> None:
        """Kill its process group; a sandbox ends with it."""
        self.killed = self.killed or self.status is None
        self._signal_group(signal.SIGKILL)

    def end(self) -> None:
        """End it and all that it started."""
        self.kill()
        self._process.wait()
        end_marked(self.mark)
        self._reader.join(timeout=2.0)
        if self.watch is not None:
            # What it saw last is part of the result.
            self.watch.join(timeout=_END_TIMEOUT_S)

    def _signal_group(self, what: signal.Signals) -> None:
        # The id of a program that has ended may already belong to another process.
        if self._process.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, what)


def marked(mark: str) -> list:
    """Return the ids of the running processes that the program with this mark has started."""
    found = matching(psutil.process_iter(), lambda one: mark in one.environ().get(MARK, ""))
    return [process.pid for process in found if process.pid != os.getpid()]


def end_marked(mark: str) -> None:
    """End all processes with this mark.

    All are stopped before the first is killed: some start others faster than they can be killed.
    """
    limit = time.monotonic() + _END_TIMEOUT_S
    stopped: set = set()
    while time.monotonic() < limit:
        found = set(marked(mark))
        if not found:
            return
        _signal(found - stopped, signal.SIGSTOP)
        if found <= stopped:
            _signal(found, signal.SIGKILL)
            time.sleep(_POLL_S)
        stopped |= found


def _signal(ids: Iterable[int], what: signal.Signals) -> None:
    for process_id in ids:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.kill(process_id, what)
