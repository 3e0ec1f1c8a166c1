"""Whether nodes of the car's software are at work, so that a busy machine costs them no tick."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence

_CLOCK_TICKS = os.sysconf("SC_CLK_TCK")
_PROCESSES = os.path.join(os.sep, "proc")
# Running or ready to run; waiting for a disk, where a busy machine also writes a node's log.
_AT_WORK = (b"R", b"D")
# When no process is known, ask again after this time.
_FIND_AGAIN_S = 1.0


class StackProcesses:
    """The processes of all nodes on the way from the odometry to the command.

    A message makes the process that receives it ready to run. While one of them is ready but gets
    no processor, or waits for a disk, an answer is on its way, however long that takes. Nodes on
    other machines, and nodes that wait for a timer of the wall clock, are never at work.

    Args:
        find: returns the process ids, those that receive the messages first before the others
    """

    def __init__(self, find: Callable[[], Sequence[int]]):
        self._find = find
        self._ids: Sequence[int] = ()
        self._found_at_s = -_FIND_AGAIN_S
        self._used_s: dict[int, float] = {}

    @property
    def found(self) -> bool:
        """Whether processes are known."""
        return bool(self._ids)

    def start_tick(self) -> None:
        """Give each process its time again."""
        self._used_s.clear()

    def at_work(self, work_s: float) -> bool:
        """Return whether a process runs, or would run if processor and disk were not busy.

        Args:
            work_s: processor time after which a process had its chance in this tick [s]
        """
        # In the order of the messages: who is idle has passed on all that it received.
        try:
            return any(self._is_at_work(process, work_s) for process in self._processes())
        except OSError:  # A process has ended.
            self._ids = ()
            return False

    def _processes(self) -> Sequence[int]:
        now_s = time.monotonic()
        if not self._ids and now_s - self._found_at_s >= _FIND_AGAIN_S:
            self._found_at_s = now_s
            self._ids = self._find()
        return self._ids

    def _is_at_work(self, process: int, work_s: float) -> bool:
        folder = f"{_PROCESSES}/{process}/"
        threads = os.listdir(folder + "task")
        if not any(_is_busy(f"{folder}task/{thread}/stat") for thread in threads):
            return False
        # Fields 14 and 15 of proc(5), counted from the third.
        used_s = sum(map(int, _fields(folder + "stat")[11:13])) / _CLOCK_TICKS
        return used_s - self._used_s.setdefault(process, used_s) < work_s


def _is_busy(path: str) -> bool:
    try:
        return _fields(path)[0] in _AT_WORK
    except OSError:  # The thread has ended.
        return False


def _fields(path: str) -> list[bytes]:
    """Return the fields of a `stat` file after the name of the program, the state first."""
    with open(path, "rb") as file:
        return file.read().rpartition(b")")[2].split()


def nodes_to(
    topics: Iterable[str],
    publishers: Mapping[str, set[str]],
    subscribers: Mapping[str, set[str]],
    own_name: str,
) -> list[str]:
    """Return the nodes whose messages lead to topics, in the order of the messages.

    Args:
        topics: names of the topics at the end of the way
        publishers: names of the nodes that publish each topic
        subscribers: names of the nodes that subscribe to each topic
        own_name: the node at the start, which is not returned
    """
    nodes: list[str] = []
    seen = {own_name}

    def add_publishers(topic: str) -> None:
        for node in sorted(publishers.get(topic, set()) - seen):
            seen.add(node)
            for name, receivers in subscribers.items():
                if node in receivers:
                    add_publishers(name)
            nodes.append(node)

    for topic in topics:
        add_publishers(topic)
    return nodes
