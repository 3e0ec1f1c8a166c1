"""Run programs under a ROS master or in a network of their own, and find their processes."""

from __future__ import annotations

import contextlib
import ctypes
import os
import socket
import struct
import subprocess
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import psutil

from sdc_common.ros.drive_master import free_master_port

# On a busy machine, a child whose parent was killed needs this time to end.
ORPHAN_S = 30.0
# Constants of the kernel: CLONE_NEWNET, CLONE_NEWUSER, SIOCSIFFLAGS and IFF_UP.
_NEW_NETWORK = 0x40000000
_NEW_USER = 0x10000000
_SET_INTERFACE_FLAGS = 0x8914
_INTERFACE_UP = 1


def isolate_network() -> bool:
    """Move this process, and all that it starts, to a network with nothing but loopback.

    ROS nodes call each other at addresses that they have got earlier. After a node has ended,
    another person's program may have its address.

    Call it before the first thread starts. It needs root, or a kernel that lets users do this.

    Returns:
        whether it is permitted; if not, nothing has changed
    """
    import fcntl  # Other systems lack it.

    unshare = ctypes.CDLL(None).unshare
    if unshare(_NEW_NETWORK) != 0:
        # A user needs a namespace of users, too. Tried elsewhere first: it cannot be left again.
        command = ["unshare", "--map-root-user", "--net", "true"]
        permitted = subprocess.run(command, capture_output=True, check=False).returncode == 0
        user, group = os.getuid(), os.getgid()
        if not permitted or unshare(_NEW_USER | _NEW_NETWORK) != 0:
            return False
        Path("/proc/self/setgroups").write_text("deny")
        Path("/proc/self/uid_map").write_text(f"{user} {user} 1")
        Path("/proc/self/gid_map").write_text(f"{group} {group} 1")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as control:
        fcntl.ioctl(control, _SET_INTERFACE_FLAGS, struct.pack("16sh14x", b"lo", _INTERFACE_UP))
    return True


def wait_until(
    condition: Callable[[], Any], seconds: float = 15.0, what: str = "the condition"
) -> Any:
    """Return the first true value of a condition, which is polled.

    Raises:
        TimeoutError: the condition, or `what` in words, is still false after `seconds`
    """
    limit = time.monotonic() + seconds
    while not (value := condition()):
        if time.monotonic() > limit:
            raise TimeoutError(f"{what} is still missing after {seconds:g} s")
        time.sleep(0.05)
    return value


def matching(
    processes: Iterable[psutil.Process], condition: Callable[[psutil.Process], bool]
) -> list[psutil.Process]:
    """Return the processes that meet a condition, without those that ended or may not be read."""
    found = []
    for process in processes:
        with contextlib.suppress(psutil.Error, OSError):
            if condition(process):
                found.append(process)
    return found


def processes_with(variable: str, value: str) -> list[psutil.Process]:
    """Return the processes, except this one, in whose environment a variable has a value.

    Those of another network are left out: in a sandbox, the same address is another ROS master.
    """
    network = os.readlink("/proc/self/ns/net")
    return matching(
        psutil.process_iter(),
        lambda process: (
            process.pid != os.getpid()
            and process.environ().get(variable) == value
            and os.readlink(f"/proc/{process.pid}/ns/net") == network
        ),
    )


def kill_left_behind(master_uri: str, timeout_s: float = ORPHAN_S) -> list[list[str]]:
    """Kill the processes of a master that do not end within a timeout; return their commands."""
    limit = time.monotonic() + timeout_s
    while (left := processes_with("ROS_MASTER_URI", master_uri)) and time.monotonic() < limit:
        time.sleep(0.1)
    killed = []
    for process in left:
        with contextlib.suppress(psutil.NoSuchProcess):
            killed.append(process.cmdline())
            process.kill()
    return killed


@contextlib.contextmanager
def isolated_ros_environment(
    ros_home: os.PathLike | str, timeout_s: float = ORPHAN_S
) -> Iterator[dict[str, str]]:
    """Provide environment variables for programs under a ROS master of their own.

    Args:
        ros_home: folder of ROS's logs
        timeout_s: time after the block in which the processes of this master may end

    Raises:
        AssertionError: after that time, a process of this master was still running; it is killed
    """
    uri = f"http://127.0.0.1:{free_master_port()}"
    yield {**os.environ, "ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1", "ROS_HOME": str(ros_home)}
    left = kill_left_behind(uri, timeout_s)
    assert not left, f"processes were left behind: {left}"
