"""Ports for ROS masters: programs that start at the same time never choose the same one."""

from __future__ import annotations

import contextlib
import fcntl
import itertools
import os
import socket
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO

_OUTGOING = Path("/proc/sys/net/ipv4/ip_local_port_range")
# Above the default port of ROS and the ports that are usually given to a second master.
_FIRST = 11500
_BLOCK = 50
_LAST = 65535


def candidate_ports(range_file: Path = _OUTGOING) -> range:
    """Return the ports below those that the kernel gives to outgoing connections.

    Args:
        range_file: file of the first and the last port of outgoing connections; it may be missing
    """
    outgoing = int(range_file.read_text().split()[0]) if range_file.exists() else _LAST
    return range(_FIRST, outgoing if outgoing >= _FIRST + _BLOCK else _LAST)


class MasterPorts:
    """A block of ports for this process.

    A lock on a file that is named after the block reserves it until the process ends, so that no
    other process that uses this class takes the same block, not even in a network of its own: a
    port also tells which processes belong together.

    Args:
        candidates: all ports that may be used, in steps of 1
    """

    def __init__(self, candidates: range):
        self._candidates = candidates
        self._reservations: list[IO] = []
        self._ports: Iterator[int] = iter(())

    def _reserve(self) -> Iterable[int]:
        first, last = self._candidates.start, self._candidates.stop - _BLOCK
        for start in range(first, last + 1, _BLOCK):
            path = f"{tempfile.gettempdir()}/ros_master_ports_{start}_{os.getuid()}.lock"
            reservation = open(path, "a")  # noqa: SIM115  it stays open until the process ends
            try:
                fcntl.flock(reservation, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                reservation.close()
                continue
            self._reservations.append(reservation)
            return range(start, start + _BLOCK)
        raise OSError(f"no free block of {_BLOCK} ports in {self._candidates}; end other programs")

    def next(self) -> int:
        """Return the next port of the block on which no program listens.

        Raises:
            OSError: no port is free
        """
        while True:
            for port in itertools.islice(self._ports, _BLOCK):
                if _is_free(port):
                    return port
            self._ports = itertools.cycle(self._reserve())


def _is_free(port: int) -> bool:
    with socket.socket() as probe, contextlib.suppress(OSError):
        probe.bind(("", port))
        return True
    return False


_ports = MasterPorts(candidate_ports())


def free_master_port() -> int:
    """Return a port for a ROS master. Raises OSError where none is free."""
    return _ports.next()
