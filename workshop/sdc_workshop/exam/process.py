"""Run a student's programs: start them, watch them, and end them with all that they started.

Such a program may crash, loop for ever, start other programs, or wait for ever; the check goes on.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
import time
from pathlib import Path
from types import TracebackType
from typing import Callable, Iterable, Sequence

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
_MAX_FAMILY = 20
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


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

    def __init__(self, command: Sequence[object], environment: dict, folder: Path | None = None):
        self.command = [str(word) for word in command]
        self.mark = f"{os.getpid()}-{time.monotonic_ns()}"
        self._pieces: list[bytes] = []
        self._size = 0
        self._inside: int | None = None
        self._process = subprocess.Popen(
            self.command,
            env={**environment, MARK: f"{os.environ.get(MARK, '')}/{self.mark}"},
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def __enter__(self) -> Program:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
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

    def wait_until(self, condition: Callable[[], object], timeout_s: float = TIMEOUT_S) -> str:
        """Wait until `condition()` is true, or will not become true any more.

        Returns:
            "true", "ended" (the program has ended), "idle" (it waits for something), "busy" (it
            used more than BUSY_CPU_S) or "late" (the timeout)
        """
        limit = time.monotonic() + timeout_s
        cpu_at_start = self._cpu_s()
        window = [(time.monotonic(), cpu_at_start)]
        while True:
            if condition():
                return "true"
            if self.status is not None:
                self._reader.join(timeout=2.0)
                return "true" if condition() else "ended"
            time.sleep(_POLL_S)
            now, cpu, running = time.monotonic(), self._cpu_s(), self._is_running()
            if running:
                window = []
            window.append((now, cpu))
            while len(window) > _IDLE_POLLS + 1 and now - window[1][0] >= IDLE_S:
                window.pop(0)
            if (
                len(window) > _IDLE_POLLS
                and now - window[0][0] >= IDLE_S
                and cpu - window[0][1] <= _IDLE_CPU_S
            ):
                return "true" if condition() else "idle"
            if cpu - cpu_at_start > BUSY_CPU_S:
                return "busy"
            if now > limit:
                return "late"

    def wait(self, timeout_s: float = TIMEOUT_S) -> int | None:
        """Return its exit status if it ends in time, else None."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout_s)
            self._reader.join(timeout=2.0)
        return self.status

    @property
    def main_id(self) -> int:
        """Id of the process of the program itself, which bwrap starts in a sandbox."""
        found = self._process.pid
        if self._inside is None:
            with contextlib.suppress(OSError, IndexError):
                while _name(found) == "bwrap":
                    found = int(Path(f"/proc/{found}/task/{found}/children").read_text().split()[0])
                self._inside = found
        return self._inside or found

    def _family(self) -> list:
        """Return the ids of its processes: a node runs in a child of its supervisor."""
        found = [self.main_id]
        for parent in found:
            with contextlib.suppress(OSError):
                # A supervisor forks in its first thread.
                children = Path(f"/proc/{parent}/task/{parent}/children")
                found += map(int, children.read_text().split())
        return found[:_MAX_FAMILY]

    def _cpu_s(self) -> float:
        total = 0
        for process_id in self._family():
            with contextlib.suppress(OSError, IndexError):
                fields = _stat(Path(f"/proc/{process_id}/stat"))
                total += int(fields[11]) + int(fields[12])
        return total / _TICKS_PER_S

    def _is_running(self) -> bool:
        """Return whether one of its threads runs, waits for a processor, or waits for a disk."""
        for process_id in self._family():
            with contextlib.suppress(OSError, IndexError):
                tasks = Path(f"/proc/{process_id}/task")
                if any(_stat(tasks / task / "stat")[0] in "RD" for task in os.listdir(tasks)):
                    return True
        return False

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


def _stat(path: Path) -> list:
    """Return the fields of a stat file of /proc after the command, the state first."""
    return path.read_text().rpartition(")")[2].split()


def _name(process_id: int) -> str:
    return Path(f"/proc/{process_id}/comm").read_text().rstrip("\n")


def marked(mark: str) -> list:
    """Return the ids of the running processes that the program with this mark has started."""
    found = []
    for name in os.listdir("/proc"):
        if name.isdigit() and int(name) != os.getpid():
            with contextlib.suppress(OSError):
                if any(
                    line.startswith(f"{MARK}=".encode()) and mark.encode() in line
                    for line in Path("/proc", name, "environ").read_bytes().split(b"\0")
                ):
                    found.append(int(name))
    return found


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
