"""Limits of the memory and shares of the processor that students' programs get.

Resident pages are not all: files in memory, shared memory and what other programs keep for them
count, too. Where the machine allows it, the kernel counts all of it in a control group, and gives
each student the same share of the processor, however many programs one of them starts.
"""

from __future__ import annotations

import contextlib
import os
import time
from pathlib import Path
from typing import Callable, Iterator

MAX_MEMORY = 2 << 30  # bytes, all processes of a program
MAX_CHECK_MEMORY = 3 << 30  # bytes, check, master and simulator of one student
# Environment variable with the control group of the student's programs.
GROUP = "SDC_WORKSHOP_GROUP"
_MAX_REQUEST, _MAX_REQUESTS = 1 << 20, 64 << 20  # bytes, of one request to the master and of all
_GROUPS = Path("/sys/fs/cgroup")
_END_S = 3.0


@contextlib.contextmanager
def control_groups(groups: Path = _GROUPS) -> Iterator[tuple]:
    """Yield the control groups of a check and of the programs in it; None without the right.

    Each is the path of a group, or two with ":" between: version 1 of the kernel's interface has
    groups of their own for the processor. The kernel shows them in the folder `groups`.
    """
    memory = _made(groups, "memory")
    both = memory and not has_share(str(memory / "check"))
    cpu = _made(groups, "cpu") if both else None
    folders = [folder for folder in (memory, cpu) if folder]
    try:
        if memory:
            yield tuple(
                ":".join(str(folder / name) for folder in folders) for name in ("check", "programs")
            )
        else:
            yield None, None
    finally:
        for folder in folders:
            _remove(folder / "check", folder / "programs", folder)


def has_share(group: str | None) -> bool:
    """Return whether the kernel gives a control group a share of the processor."""
    names = ("cpu.weight", "cpu.shares")
    return any(Path(path, name).exists() for path in (group or "").split(":") for name in names)


def _made(groups: Path, controller: str) -> Path | None:
    """Make a group with the groups `check` and `programs` in it; None without the right."""
    for parent in _parents(groups, controller):
        folder = parent / f"sdc_grade_{os.getpid()}_{time.monotonic_ns()}"
        made = (folder / "check", folder / "programs")
        try:
            folder.mkdir()
            if (folder / "cgroup.controllers").exists():  # version 2
                # A group passes controllers on to the groups in it, unless it has processes.
                for group in (parent, folder):
                    for controllers in ("+memory", "+memory +cpu"):
                        with contextlib.suppress(OSError):
                            (group / "cgroup.subtree_control").write_text(controllers)
            for group, limit in zip(made, (MAX_CHECK_MEMORY, MAX_MEMORY)):
                group.mkdir()
                if controller == "memory":
                    _limit(group, limit)
            return folder
        except OSError:
            _remove(*made, folder)
    return None


def _parents(groups: Path, controller: str) -> Iterator[Path]:
    """Yield the groups above this process, the nearest first, of version 2 and of version 1."""
    for line in Path("/proc/self/cgroup").read_text(encoding="ascii").splitlines():
        _, controllers, path = line.split(":", 2)
        if controller in controllers.split(",") or (controllers == "" and controller == "memory"):
            top = groups / controllers
            own = Path(path.lstrip("/"))
            yield from (top / folder for folder in (own, *own.parents))


def _limit(group: Path, limit: int) -> None:
    memory, swap, swapped = "memory.limit_in_bytes", "memory.memsw.limit_in_bytes", limit
    if (group / "memory.max").exists():  # version 2
        memory, swap, swapped = "memory.max", "memory.swap.max", 0
    with (group / memory).open("r+") as file:  # no new file where the kernel has none
        file.write(str(limit))
    if (group / swap).exists():  # a kernel may not count what it swaps
        (group / swap).write_text(str(swapped))


def _remove(*folders: Path) -> None:
    """Remove groups; the kernel keeps them for a moment after their last process."""
    until = time.monotonic() + _END_S
    while any(folder.is_dir() for folder in folders) and time.monotonic() < until:
        for folder in folders:
            with contextlib.suppress(OSError):
                folder.rmdir()
        time.sleep(0.01)


def kills(group: str | None) -> int:
    """Return how many processes of a group the kernel has ended, for want of memory."""
    for name in ("memory.events", "memory.oom_control") if group else ():
        with contextlib.suppress(OSError):
            path = Path(str(group).partition(":")[0], name)
            rows = (line.split() for line in path.read_text().splitlines())
            return next((int(row[1]) for row in rows if row[0] == "oom_kill"), 0)
    return 0


def entering(group: object, command: list) -> list:
    """Return a command line that runs a command in a control group, or as it is without one."""
    enter = '{ echo 0 >"$group/cgroup.procs"; } 2>/dev/null'
    script = f'IFS=:; for group in $0; do {enter}; done; exec "$@"'
    return ["sh", "-c", script, str(group), *command] if group else command


def limit_requests(report: Callable[[str], None]) -> None:
    """Limit what the masters and nodes that this process starts from now on receive and keep."""
    import rosgraph.xmlrpc

    received = 0

    class Limited(rosgraph.xmlrpc.SilenceableXMLRPCRequestHandler):
        def do_POST(self) -> None:
            nonlocal received
            size = self.headers.get("Content-Length", "")
            if size.isascii() and size.isdigit() and "Content-Encoding" not in self.headers:
                received += min(int(size), _MAX_REQUEST)
                if int(size) <= _MAX_REQUEST and received <= _MAX_REQUESTS:
                    super().do_POST()
                    return
            report("more than allowed was sent to the ROS master")
            self.close_connection = True
            self.send_error(413)

    rosgraph.xmlrpc.SilenceableXMLRPCRequestHandler = Limited
