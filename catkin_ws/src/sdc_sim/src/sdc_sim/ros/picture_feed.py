"""The edge between the simulator and the node that takes the pictures: a socket of one machine.

The pictures need the true state of every tick, which no topic shows to the vehicle's software.
"""

from __future__ import annotations

import contextlib
import os
import socket
import time
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

import rospy

from sdc_sim.simulation.snapshot import Snapshot

# In lockstep the simulator may be so many pictures ahead, which evens out their render times.
_DEPTH = 6
# Wall time to wait for a picture, and for the start of the node with its imports.
_TIMEOUT_S = 10.0
_START_TIMEOUT_S = 120.0


class PictureSettings(NamedTuple):
    """What the pictures of a drive have in common.

    Attributes:
        waypoints_path: CSV file of the route
        role_name: name of the vehicle in topics and frames
        bridge: version of the bridge, a key of BRIDGE_VERSIONS
        daylight: brightness, 0..1
        weather: fields of Weather
        every_frame: whether each observation is published (lockstep); else one that arrives while
            a picture is painted is dropped
    """

    waypoints_path: str
    role_name: str
    bridge: str
    daylight: float
    weather: dict[str, Any]
    every_frame: bool


class PictureFeed:
    """The end of the simulator: sends observations to the node, which acknowledges each picture.

    Roslaunch starts a node again that was killed; it connects and gets the settings again.

    Args:
        path: file name of the socket
        settings: what the node receives when it connects
    """

    def __init__(self, path: str, settings: PictureSettings):
        self._path = path
        self._settings = settings
        self._connection: Connection | None = None
        self._pending = 0
        self._starting = True
        self._slow = False
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.bind(path)
        self._socket.listen(1)
        rospy.on_shutdown(self._close)

    @property
    def is_ready(self) -> bool:
        """Whether the node has started and can take an observation."""
        return self._wait(_DEPTH - 1, 0.0)

    def show(self, observation: Snapshot, again: bool = False) -> None:
        """Send an observation to be painted and published.

        Args:
            observation: the observation
            again: whether it has been sent before; it is then dropped if the camera is busy
        """
        if self._settings.every_frame and not again:
            self._put(observation)
        elif self._wait(0, 0.0):
            self._send(observation)

    def _put(self, observation: Snapshot) -> None:
        """Wait until there is room, but after a timeout not again before the next picture."""
        limit_s = _START_TIMEOUT_S if self._starting else _TIMEOUT_S
        if self._wait(_DEPTH - 1, 0.0 if self._slow else limit_s):
            self._send(observation)
        elif not self._slow:
            self._slow = True
            task = "start" if self._starting else "finish a picture"
            rospy.logwarn(
                "sim: front_camera did not %s within %g s; pictures are missing", task, limit_s
            )

    def _wait(self, most_pending: int, timeout_s: float) -> bool:
        """Wait until so few pictures are not acknowledged; return whether that happened."""
        deadline_s = time.monotonic() + timeout_s
        while not rospy.is_shutdown():
            left_s = max(0.0, deadline_s - time.monotonic())
            if self._connection is None:
                self._accept(left_s)
            else:
                self._receive(0.0 if self._pending <= most_pending else left_s)
            if self._connection is not None and self._pending <= most_pending:
                return True
            if left_s == 0.0:
                return False
        return False

    def _accept(self, timeout_s: float) -> None:
        self._socket.settimeout(timeout_s)
        with contextlib.suppress(OSError):
            peer, _ = self._socket.accept()
            peer.setblocking(True)
            self._connection = Connection(peer.detach())
            self._pending = 1  # the node acknowledges its start like a picture
            self._starting = True
            self._connection.send(self._settings)

    def _receive(self, timeout_s: float) -> None:
        """Wait for an acknowledgement, and count all that have arrived."""
        assert self._connection is not None
        try:
            while self._connection.poll(timeout_s):
                self._connection.recv_bytes()
                self._pending -= 1
                self._starting = self._slow = False
                timeout_s = 0.0
        except (EOFError, OSError):
            self._end()

    def _send(self, observation: Snapshot) -> None:
        assert self._connection is not None
        try:
            self._connection.send(observation)
            self._pending += 1
        except OSError:
            self._end()

    def _end(self) -> None:
        assert self._connection is not None
        rospy.logwarn("sim: front_camera has ended; waiting until it is started again")
        self._connection.close()
        self._connection = None
        self._starting = True

    def _close(self) -> None:
        self._socket.close()
        with contextlib.suppress(OSError):
            os.unlink(self._path)


def connect(path: str) -> Connection:
    """Return the connection of the node to the simulator; wait until the simulator listens.

    Raises:
        ROSInterruptException: the node shuts down
    """
    while not rospy.is_shutdown():
        end = socket.socket(socket.AF_UNIX)
        try:
            end.connect(path)
            return Connection(end.detach())
        except OSError:
            time.sleep(0.1)
    raise rospy.ROSInterruptException("no simulator")
