"""Ports for ROS masters: programs that start at the same time never choose the same one."""

from __future__ import annotations

import contextlib
import fcntl
import itertools
import os
import socket
import tempfile
from functools import lru_cache
from typing import IO, Iterator

# Above the default port of ROS and the ports that are usually given to a second master, and below
# those that Linux gives to outgoing connections.
_FIRST, _LAST = 11500, 32750
_BLOCK = 50


def free_master_port() -> int:
    """Return a port for a ROS master on which no program listens.

    A process has a block of ports and uses them in turn.

    Raises:
        OSError: no port is free
    """
    ports, _ = _reserved_block()
    for port in itertools.islice(ports, _BLOCK):
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind(("", port))
            return port
    raise OSError(f"none of {_BLOCK} ports is free; end other programs")


@lru_cache(maxsize=1)
def _reserved_block() -> tuple[Iterator[int], IO]:
    """Return the ports of a block that no other process has, and the lock file that reserves it.

    The lock ends with the process. It also excludes processes in a network of their own, so that a
    port identifies the processes of one master.
    """
    for start in range(_FIRST, _LAST, _BLOCK):
        path = f"{tempfile.gettempdir()}/ros_master_ports_{start}_{os.getuid()}.lock"
        reservation = open(path, "a")  # noqa: SIM115  it stays open until the process ends
        with contextlib.suppress(OSError):
            fcntl.flock(reservation, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return itertools.cycle(range(start, start + _BLOCK)), reservation
        reservation.close()
    raise OSError(f"no free block of {_BLOCK} ports in {_FIRST}..{_LAST}; end other programs")
