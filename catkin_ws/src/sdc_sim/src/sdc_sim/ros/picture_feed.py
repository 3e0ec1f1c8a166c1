"""The edge between the simulator and the node that takes the pictures: a socket of one machine.

The pictures need the true state of every tick, which no topic shows to the vehicle's software.
The node receives the settings when it connects, and then one observation for each request. The
name of the socket is a parameter, which any user of the machine can set. So both ends refuse a
process of another user, and decode JSON alone: no message can run code.
"""

from __future__ import annotations

import json
import os
import queue
import socket
import struct
import threading
import time
from multiprocessing import AuthenticationError
from multiprocessing.connection import Client, Connection, Listener
from typing import Any, NamedTuple

import rospy

from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import TrafficLightState
from sdc_sim.physics.vehicle import VehicleState
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
_REFUSED_S = 1.0  # wall time after which a socket of another user is tried again
_CREDENTIALS = struct.Struct("iII")  # process, user and group of the other end
MAX_MESSAGE = 1 << 20  # bytes
# Begins an address in Linux's abstract namespace, which leaves no file.
_NO_FILE = "\0"


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


def packed(observation: Snapshot) -> bytes:
    """Return the record of what a picture shows of an observation."""
    state, around = observation.state, (observation.obstacles, observation.traffic_lights)
    pose = state.x_m, state.y_m, state.yaw_rad
    return json.dumps((observation.stamp_ns, pose, *around)).encode()


def unpacked(record: bytes) -> Snapshot:
    """Return the observation of a record.

    Raises:
        ValueError: it is no such record
    """
    try:
        stamp_ns, pose, obstacles, lights = json.loads(record)
        state, bodies = VehicleState(*pose), tuple(ObstacleState(*row) for row in obstacles)
        shown = tuple(TrafficLightState(*row) for row in lights)
    except TypeError as error:
        raise ValueError(str(error)) from None
    return Snapshot(stamp_ns, state, state, bodies, shown)


class PictureFeed:
    """The end of the simulator: sends an observation for each request of the node.

    Roslaunch starts a node again that was killed; it connects and gets the settings again.
    """

    def __init__(self, name: str, settings: PictureSettings):
        self._settings = settings
        self._observations: queue.Queue[Snapshot] = queue.Queue(_DEPTH)
        self._started = False
        self._slow = False
        self._requested = threading.Event()
        self._listener = Listener(_NO_FILE + name, "AF_UNIX", authkey=_key())
        threading.Thread(target=self._serve, daemon=True).start()

    @property
    def is_ready(self) -> bool:
        """Whether the node has started and waits for an observation."""
        return self._requested.is_set()

    def show(self, observation: Snapshot, again: bool = False) -> None:
        """Send an observation to be painted; a busy camera gets none that is sent `again`."""
        if self._settings.every_frame and not again:
            self._put(observation)
        elif self.is_ready:
            self._requested.clear()
            self._observations.put(observation)

    def _put(self, observation: Snapshot) -> None:
        """Wait until there is room, but after a timeout not again before the next picture."""
        limit_s = _TIMEOUT_S if self._started else _START_TIMEOUT_S
        try:
            self._observations.put(observation, not self._slow, limit_s)
            self._slow = False
        except queue.Full:
            if not self._slow:
                task = "finish a picture" if self._started else "start"
                rospy.logwarn(
                    "sim: front_camera did not %s within %g s; pictures are missing", task, limit_s
                )
            self._slow = True

    def _serve(self) -> None:
        while True:
            try:
                with self._listener.accept() as node:
                    if not _is_own(node):
                        continue
                    node.send_bytes(json.dumps(self._settings._asdict()).encode())
                    while True:
                        node.recv_bytes(MAX_MESSAGE)
                        self._started = True
                        self._requested.set()
                        observation = self._observations.get()
                        self._requested.clear()
                        node.send_bytes(packed(observation))
            except (AuthenticationError, EOFError, OSError):
                self._started = False
                self._requested.clear()
                rospy.logwarn("sim: front_camera has ended; waiting until it is started again")


def connect(name: str) -> tuple[Connection, PictureSettings]:
    """Return the connection of the node to the simulator; wait until the simulator listens.

    Raises:
        ROSInterruptException: the node shuts down
    """
    while not rospy.is_shutdown():
        try:
            connection = Client(_NO_FILE + name, "AF_UNIX", authkey=_key())
        except OSError:
            time.sleep(_POLL_S)
            continue
        if _is_own(connection):
            return connection, PictureSettings(**json.loads(connection.recv_bytes(MAX_MESSAGE)))
        connection.close()
        rospy.logerr(f"front_camera: the socket {name} belongs to another user; not connected")
        time.sleep(_REFUSED_S)
    raise rospy.ROSInterruptException("no simulator")


def _is_own(connection: Connection) -> bool:
    """Return whether the process at the other end is one of this user."""
    with socket.socket(fileno=os.dup(connection.fileno())) as link:
        # rospy sets a default timeout, with which a new socket does not block; nor does its copy.
        link.setblocking(True)
        found = link.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    return _CREDENTIALS.unpack(found)[1] == os.geteuid()


def _key() -> bytes | None:
    return os.environ.get(KEY_VARIABLE, "").encode() or None
