"""The edge between the simulator and the node that takes the pictures: a socket of one machine.

The pictures need the true state of every tick, which no topic shows to the vehicle's software.
The node receives the settings when it connects, and then one observation for each request.
"""

from __future__ import annotations

import os
import queue
import threading
import time
from multiprocessing import AuthenticationError
from multiprocessing.connection import Client, Connection, Listener
from typing import Any, NamedTuple

import rospy

from sdc_sim.simulation.snapshot import Snapshot

# In lockstep so many observations may wait for the node, which evens out its render times.
_DEPTH = 3
# An environment variable, for a drive in which other programs must not get the true state: both
# ends have the same key in it, and roslaunch passes it to them.
KEY_VARIABLE = "SDC_PICTURE_KEY"
# Wall time to wait for a picture, and for the start of the node with its imports.
_TIMEOUT_S = 10.0
_START_TIMEOUT_S = 120.0
_POLL_S = 0.1


class PictureSettings(NamedTuple):
    """What the pictures of a drive have in common."""

    waypoints_path: str  # CSV file of the route
    map_path: str  # map of streets, "" for the road along the route
    role_name: str  # name of the vehicle in topics and frames
    bridge: str  # version of the bridge, a key of BRIDGE_VERSIONS
    daylight: float  # brightness, 0..1
    weather: dict[str, Any]  # fields of Weather
    # Whether each observation is published (lockstep); else one that arrives while a picture is
    # painted is dropped.
    every_frame: bool


class PictureFeed:
    """The end of the simulator: sends an observation for each request of the node.

    Roslaunch starts a node again that was killed; it connects and gets the settings again.

    Args:
        name: name of the socket
        settings: what the node receives when it connects
    """

    def __init__(self, name: str, settings: PictureSettings):
        self._settings = settings
        self._observations: queue.Queue[Snapshot] = queue.Queue(_DEPTH)
        self._started = False
        self._slow = False
        self._requested = threading.Event()
        self._listener = Listener(_address(name), "AF_UNIX", authkey=_key())
        threading.Thread(target=self._serve, daemon=True).start()

    @property
    def is_ready(self) -> bool:
        """Whether the node has started and waits for an observation."""
        return self._requested.is_set()

    def show(self, observation: Snapshot, again: bool = False) -> None:
        """Send an observation to be painted and published.

        Args:
            observation: the observation
            again: whether it has been sent before; it is then dropped if the camera is busy
        """
        if self._settings.every_frame and not again:
            self._put(observation)
        elif self.is_ready:
            self._requested.clear()
            self._observations.put(observation)

    def _put(self, observation: Snapshot) -> None:
        """Wait until there is room, but after a timeout not again before the next picture."""
        started = self._started
        limit_s = _TIMEOUT_S if started else _START_TIMEOUT_S
        try:
            self._observations.put(observation, not self._slow, limit_s)
            self._slow = False
        except queue.Full:
            if not self._slow:
                task = "finish a picture" if started else "start"
                rospy.logwarn(
                    "sim: front_camera did not %s within %g s; pictures are missing", task, limit_s
                )
            self._slow = True

    def _serve(self) -> None:
        while True:
            try:
                with self._listener.accept() as node:
                    node.send(self._settings)
                    while True:
                        node.recv_bytes()
                        self._started = True
                        self._requested.set()
                        observation = self._observations.get()
                        self._requested.clear()
                        node.send(observation)
            except (AuthenticationError, EOFError, OSError):
                self._started = False
                self._requested.clear()
                rospy.logwarn("sim: front_camera has ended; waiting until it is started again")


def connect(name: str) -> Connection:
    """Return the connection of the node to the simulator; wait until the simulator listens.

    Raises:
        ROSInterruptException: the node shuts down
    """
    while not rospy.is_shutdown():
        try:
            return Client(_address(name), "AF_UNIX", authkey=_key())
        except OSError:
            time.sleep(_POLL_S)
    raise rospy.ROSInterruptException("no simulator")


def _key() -> bytes | None:
    return os.environ.get(KEY_VARIABLE, "").encode() or None


def _address(name: str) -> str:
    """Return a socket address that leaves no file: it is in Linux's abstract namespace."""
    return "\0" + name
