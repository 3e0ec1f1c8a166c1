"""Ports for ROS masters: programs that start at the same time never choose the same one."""

from __future__ import annotations

import contextlib
import socket

# Above the default port of ROS and the ports that are usually given to a second master, below those
# that the kernel gives to outgoing connections.
_PORTS = range(11500, 32768)

_reserved: list[socket.socket] = []


def reserve(name: str) -> socket.socket | None:
    """Reserve a name for this process on this machine; return None where it is reserved already.

    The name is the address of a Unix socket, without a file: it is free again when the socket is
    closed, also by the end of the process. All users of the machine see the same names.
    """
    reservation = socket.socket(socket.AF_UNIX)
    try:
        reservation.bind("\0" + name)
    except OSError:
        reservation.close()
        return None
    return reservation


def free_master_port() -> int:
    """Return a port for a ROS master, which this function returns to no other running process.

    Raises:
        OSError: no port is free
    """
    for port in _PORTS:
        if (reservation := reserve(f"ros_master_port_{port}")) is not None:
            if _is_free(port):
                _reserved.append(reservation)
                return port
            reservation.close()
    raise OSError(f"no free port in {_PORTS}; end other programs")


def _is_free(port: int) -> bool:
    with socket.socket() as probe, contextlib.suppress(OSError):
        probe.bind(("", port))
        return True
    return False
