"""Watch a program in its sandbox: end it when it uses too much, and name what it tried."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Callable

import psutil

from sdc_common.processes import matching
from sdc_experiments.sandbox import MAX_DISK
from sdc_workshop.exam.limits import GROUP, MAX_MEMORY, kills

if TYPE_CHECKING:
    from sdc_workshop.exam.process import Program

# The command of a process beside each program, which shows whether the program kills others.
BYSTANDER = ("sleep", "98989")
MAX_PROCESSES = 150
# The kernel keeps up to some 400 kB for each, which no process shows; a drive uses some 200.
MAX_SOCKETS = 1000
_POLL_S = 0.1
# Exit status of bwrap when a signal of the program's own has killed it.
_KILLED = 128 + signal.SIGKILL
_KILLS = "processes of others were killed"
# Less than this of a folder is free: it is full.
_FULL = 1 << 20
# Errors of Python, bash and others that a limit of the sandbox causes, and what they mean.
_TRACES = (
    (r"^MemoryError|[Cc]annot allocate memory", "more memory than allowed was asked for"),
    (r"No space left on device|File too large", "more was written than allowed"),
    (r"Resource temporarily unavailable|can't start new thread", "more processes than allowed"),
    (r"Too many open files", "more files and sockets than allowed were opened"),
    (r"^ConnectionRefusedError|Network is unreachable", "a network connection was refused"),
)
_MISSING = re.compile(
    r"(?:No such file or directory|Permission denied|Read-only file system): '(/[^']+)'"
    r"|(/[^\s:'\"]+)['\"]?: (?:No such file or directory|Permission denied|Read-only file system)"
)


class Watch(threading.Thread):
    """Ends a program, which is bwrap, that uses too much; at its end, names what it tried.

    `report` receives a sentence about each event, and the path that it is about, or "".
    """

    def __init__(self, program: Program, scratch: Path, report: Callable[[str, str], None]):
        super().__init__(daemon=True)
        self._program = program
        self._scratch = scratch
        self._report = report
        self._bystander: psutil.Process | None = None
        self._was_missing = False
        self._group = os.environ.get(GROUP)
        self._kills = kills(self._group)

    def run(self) -> None:
        """Watch until the program ends."""
        while self._program.status is None:
            with contextlib.suppress(psutil.Error):
                tree = psutil.Process(self._program.process_id).children(recursive=True)
                self._look_for_bystander(tree)
                found = self._excess(tree)
                if found:
                    self._report(found, "")
                    self._program.kill()
                    return
            time.sleep(_POLL_S)
        if self._program.status == _KILLED and not self._program.killed:
            self._report(_KILLS, "")
        for text, path in traces(self._program.output).items():
            self._report(text, path)

    def _look_for_bystander(self, tree: list) -> None:
        if self._bystander is None:
            found = matching(tree, lambda process: tuple(process.cmdline()) == BYSTANDER)
            self._bystander = found[0] if found else None
            return
        missing = self._bystander not in tree and self._program.main in tree
        # Where the check ends the program itself, its processes end in any order.
        if missing and self._was_missing and not self._program.killed:
            self._report(_KILLS, "")
        self._was_missing = missing

    def _excess(self, tree: list) -> str:
        if len(tree) > MAX_PROCESSES:
            return f"more than {MAX_PROCESSES} processes were started, and ended"
        sockets = int(Path("/proc/net/sockstat").read_text(encoding="ascii").split()[2])
        if sockets > MAX_SOCKETS:
            return f"more than {MAX_SOCKETS} sockets were opened, and the programs ended"
        memory: list = []
        matching(tree, lambda process: memory.append(process.memory_info().rss))
        root = f"/proc/{tree[-1].pid}/root" if tree else ""
        for folder in ("/tmp", "/dev/shm", self._scratch) if tree else ():
            with contextlib.suppress(OSError):
                seen = os.statvfs(f"{root}{folder}")
                if seen.f_blocks * seen.f_bsize <= MAX_DISK:  # else bwrap has not mounted it yet
                    memory.append((seen.f_blocks - seen.f_bfree) * seen.f_bsize)
        if sum(memory) > MAX_MEMORY or kills(self._group) > self._kills:
            return f"more than {MAX_MEMORY >> 20} MB of memory were used, and the programs ended"
        with contextlib.suppress(OSError):
            seen = os.statvfs(f"{root}{self._scratch}")
            if seen.f_bavail * seen.f_bsize < _FULL:
                return "the disk space was filled, and the programs ended"
        return ""


def traces(output: str) -> dict:
    """Return sentences about limits in the output of a program, each with its path, or ""."""
    found = {text: "" for pattern, text in _TRACES if re.search(pattern, output, re.MULTILINE)}
    for match in _MISSING.finditer(output):
        path = match[1] or match[2]
        found[f"{path} is missing, invisible or read only in the sandbox"] = path
    return found
