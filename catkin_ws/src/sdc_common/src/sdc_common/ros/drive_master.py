"""Run a command under a ROS master that no other drive uses.

    python3 -m sdc_common.ros.drive_master PROGRAM COMMAND [ARGUMENT ...]

PROGRAM is the name for its messages. The command runs under the master of ROS_MASTER_URI. If that
is the default one and it is in use, the command gets a master on a free port. A master is free if
it belongs to this user and neither a simulator nor a cockpit runs on it, such as a roscore in
another terminal. A master that the user has chosen is never replaced: if a drive runs on it, this
program prints one line and ends with status 2. The same holds with the argument sim:=false, because
another program drives the world on that master.

Where no master runs yet, the command must start it: see `sdc_sim.ros.safe_launch`.
"""

from __future__ import annotations

import contextlib
import http.client
import os
import socket
import sys
import urllib.parse
import xmlrpc.client
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

DEFAULT_PORT = 11311
# The master that an enclosing program, such as ./cockpit, has chosen for this one.
CHOSEN_VARIABLE = "SDC_MASTER_URI"
# Set if no master runs yet, so that the command does not join one that appears meanwhile.
NEW_MASTER_VARIABLE = "SDC_NEW_MASTER"
_LOOPBACK = ("localhost", "127.0.0.1")
_CALLER = "/drive_master"
_TIMEOUT_S = 3.0
# What a call raises if no master or node responds.
_NO_ANSWER = (OSError, xmlrpc.client.Error, http.client.HTTPException)
# Above the default port of ROS and the ports that are usually given to a second master, below those
# that the kernel gives to outgoing connections.
_PORTS = range(11500, 32768)

_reserved: list[socket.socket] = []


def reserve(name: str) -> socket.socket | None:
    """Reserve a name for this process on this machine; return None where it is reserved already.

    The name is the address of a Unix socket, without a file: all users of the machine see it, and
    it is free again when the socket is closed, also by the end of the process.
    """
    reservation = socket.socket(socket.AF_UNIX)
    try:
        reservation.bind("\0" + name)
    except OSError:
        reservation.close()
        return None
    return reservation


def _port_name(port: int | None) -> str:
    return f"ros_master_port_{port}"


def free_master_port() -> int:
    """Return a port for a ROS master, which this function returns to no other running process.

    Raises:
        OSError: no port is free
    """
    for port in _PORTS:
        if (reservation := reserve(_port_name(port))) is not None:
            with socket.socket() as probe, contextlib.suppress(OSError):
                probe.bind(("", port))
                _reserved.append(reservation)
                return port
            reservation.close()
    raise OSError(f"no free port in {_PORTS}; end other programs")


class MasterInUse(ValueError):
    """The user's master is in use; the message is one line."""


class ChosenMaster(NamedTuple):
    """A master for a drive."""

    uri: str  # its ROS_MASTER_URI
    default_user: str = ""  # who uses the default master, if another one was chosen
    # Reserves the master until it is closed; None where the caller has reserved it
    reservation: socket.socket | None = None


def _proxy(uri: str) -> Any:
    return xmlrpc.client.ServerProxy(uri)


def running_node(uri: str, names: Iterable[str]) -> str:
    """Return which of these nodes runs on a master, with its host and process.

    Returns:
        a text such as "/sim (host lab3, process 4711)"; empty if none runs
    """
    for name in names:
        # A node that was killed stays registered, but it does not respond.
        with contextlib.suppress(*_NO_ANSWER):
            found, _, node_uri = _proxy(uri).lookupNode(_CALLER, name)
            if found == 1:
                pid = _proxy(node_uri).getPid(_CALLER)[2]
                host = urllib.parse.urlsplit(node_uri).hostname
                return f"{name} (host {host}, process {pid})"
    return ""


def choose_master(
    environment: Mapping[str, str], joins_world: bool = False, default_port: int = DEFAULT_PORT
) -> ChosenMaster:
    """Choose the master of a drive or a cockpit.

    Args:
        environment: environment variables with ROS_MASTER_URI
        joins_world: another program drives the world on this master
        default_port: port of ROS_MASTER_URI where the user has not chosen one

    Raises:
        MasterInUse: the master is in use and must not be replaced
    """
    uri = environment["ROS_MASTER_URI"].rstrip("/")
    address = urllib.parse.urlsplit(uri)
    if environment.get(CHOSEN_VARIABLE) == uri:
        return ChosenMaster(uri)
    reservation, user = None, ""
    is_local = address.hostname in _LOOPBACK
    if is_local:
        reservation = reserve(f"ros_drive_master_{address.port}")
        user = "" if reservation else "another drive or cockpit"
    user = running_node(uri, ("/referee" if joins_world else "/sim", "/cockpit")) or user
    is_default = is_local and address.port == default_port
    if is_default and not joins_world:
        user = user or _owner_other_than_this_user(uri)
    if not user:
        if is_local and (held := reserve(_port_name(address.port))) is not None:
            _reserved.append(held)
        return ChosenMaster(uri, reservation=reservation)
    if reservation is not None:
        reservation.close()
    if not is_default or joins_world:
        raise MasterInUse(f"ROS_MASTER_URI={uri} is in use by {user}; end it, or set another port")
    while True:
        port = free_master_port()
        # Another drive that has chosen this port may not have started its master yet.
        if reservation := reserve(f"ros_drive_master_{port}"):
            return ChosenMaster(f"http://{address.hostname}:{port}", user, reservation)


def _owner_other_than_this_user(uri: str) -> str:
    try:
        pid = _proxy(uri).getPid(_CALLER)[2]
        own = Path(f"/proc/{pid}").stat().st_uid == os.getuid()
        return "" if own else f"the ROS master of another user (process {pid})"
    except ConnectionRefusedError:
        return ""
    except _NO_ANSWER:
        return "another program"


def clear_parameters(uri: str) -> bool:
    """Delete the parameters of nodes that do not run: an earlier drive left them on this master.

    Returns:
        whether a master responds
    """
    master = _proxy(uri)
    with contextlib.suppress(*_NO_ANSWER):
        state = master.getSystemState(_CALLER)[2]
        running = {node.split("/")[1] for kind in state for _, nodes in kind for node in nodes}
        for name, value in master.getParam(_CALLER, "/")[2].items():
            # Those of the master itself are "roslaunch" and single values.
            if isinstance(value, dict) and name not in {"roslaunch", *running}:
                master.deleteParam(_CALLER, f"/{name}")
        return True
    return False


def main() -> None:
    """Choose a master and become the command."""
    program, command = sys.argv[1], sys.argv[2:]
    joins_world = "sim:=false" in command
    socket.setdefaulttimeout(_TIMEOUT_S)
    try:
        chosen = choose_master(os.environ, joins_world)
    except MasterInUse as error:
        print(f"{program}: {error}", file=sys.stderr)
        sys.exit(2)
    if chosen.default_user:
        print(
            f"{program}: the default ROS master is in use by {chosen.default_user}; this one is "
            f"ROS_MASTER_URI={chosen.uri}. To join it in another terminal:\n"
            f"    export ROS_MASTER_URI={chosen.uri}",
            file=sys.stderr,
            flush=True,
        )
    if not joins_world:
        os.environ[NEW_MASTER_VARIABLE] = "" if clear_parameters(chosen.uri) else "1"
    # The command holds the reservations of this process: its master has not taken the port yet.
    for reservation in (*_reserved, *filter(None, [chosen.reservation])):
        reservation.set_inheritable(True)
    os.environ.update({"ROS_MASTER_URI": chosen.uri, CHOSEN_VARIABLE: chosen.uri})
    os.execvp(command[0], command)


if __name__ == "__main__":
    main()
