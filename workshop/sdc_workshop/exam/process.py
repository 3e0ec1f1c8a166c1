"""Programs of a student's: started, watched, and ended whatever they do. A program may crash, run in circles, start others, or wait for
ever; none of that may reach whoever examines it."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
import time
from pathlib import Path

# Marks all that a program starts, even what leaves its process group, by a line of its environment.
MARK = "SDC_WORKSHOP_EXAM"

IDLE_S = 0.8
_POLL_S = 0.02
# So many looks, too: whoever looks may itself have had to wait for a processor, and the program for its answer.
_IDLE_LOOKS = 30
# Processor time in this window that a program which only waits may use (timers, the threads of rospy), in seconds.
_IDLE_CPU_S = 0.04
# Nobody needs that much processor time for one picture or one path.
BUSY_CPU_S = 3.0
PATIENCE_S = 60.0
_END_LIMIT_S = 30.0
_KEPT_OUTPUT = 200_000
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


class Program:
    """A running program and what it says, standard output and error together. Ends with the `with` block."""

    def __init__(self, command, environment: dict, folder=None):
        self.command = [str(word) for word in command]
        self.mark = f"{os.getpid()}-{time.monotonic_ns()}"
        self._said = []
        self._size = 0
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

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()

    def _read(self):
        with self._process.stdout as pipe:
            for piece in iter(lambda: pipe.read1(65536), b""):
                if self._size < _KEPT_OUTPUT:
                    self._said.append(piece)
                    self._size += len(piece)

    @property
    def output(self) -> str:
        """What it has said until now."""
        return b"".join(self._said).decode(errors="replace")

    @property
    def status(self) -> int | None:
        """Its exit status; None while it runs."""
        return self._process.poll()

    def wait_until(self, condition, patience_s: float = PATIENCE_S) -> str:
        """Wait until `condition()` is true, and say how it came: "true", "ended" (the program has ended), "idle" (it waits and
        does nothing more), "busy" (it has run in circles) or "late"."""
        limit = time.monotonic() + patience_s
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
            while len(window) > _IDLE_LOOKS + 1 and now - window[1][0] >= IDLE_S:
                window.pop(0)
            if (
                len(window) > _IDLE_LOOKS
                and now - window[0][0] >= IDLE_S
                and cpu - window[0][1] <= _IDLE_CPU_S
            ):
                return "true" if condition() else "idle"
            if cpu - cpu_at_start > BUSY_CPU_S:
                return "busy"
            if now > limit:
                return "late"

    def wait(self, patience_s: float = PATIENCE_S) -> int | None:
        """Its exit status when it ends in time, None otherwise."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(patience_s)
            self._reader.join(timeout=2.0)
        return self.status

    def _cpu_s(self) -> float:
        with contextlib.suppress(OSError, IndexError):
            fields = Path(f"/proc/{self._process.pid}/stat").read_text().rpartition(")")[2].split()
            return (int(fields[11]) + int(fields[12])) / _TICKS_PER_S
        return 0.0

    def _is_running(self) -> bool:
        """Whether a thread of it runs, or would run if a processor were free, or waits for a disk."""
        with contextlib.suppress(OSError, IndexError):
            for task in os.listdir(f"/proc/{self._process.pid}/task"):
                if (
                    Path(f"/proc/{self._process.pid}/task/{task}/stat")
                    .read_text()
                    .rpartition(")")[2]
                    .split()[0]
                    in "RD"
                ):
                    return True
        return False

    def interrupt(self) -> None:
        """Ctrl-C."""
        self._signal_group(signal.SIGINT)

    def end(self) -> None:
        """End it and all that it started."""
        self._signal_group(signal.SIGKILL)
        self._process.wait()
        end_marked(self.mark)
        self._reader.join(timeout=2.0)

    def _signal_group(self, what) -> None:
        # The number of a program that has ended may belong to somebody else by now.
        if self._process.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, what)


def marked(mark: str) -> list:
    """Numbers of the running processes that a program with this mark has started, itself included."""
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
    """End all processes with this mark. Those that start others faster than they could be ended are stopped first, one and all."""
    limit = time.monotonic() + _END_LIMIT_S
    stopped = set()
    while time.monotonic() < limit:
        found = set(marked(mark))
        if not found:
            return
        _signal(found - stopped, signal.SIGSTOP)
        if found <= stopped:
            _signal(found, signal.SIGKILL)
            time.sleep(_POLL_S)
        stopped |= found


def _signal(numbers, what) -> None:
    for number in numbers:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.kill(number, what)
