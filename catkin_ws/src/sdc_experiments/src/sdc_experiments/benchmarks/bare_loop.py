"""The driving loop without algorithms: three processes that only exchange messages with rospy.

Its time per tick is the lower limit of a lockstep tick. This module runs one of its two nodes:

python3 -m sdc_experiments.benchmarks.bare_loop planner|controller
"""

from __future__ import annotations

import contextlib
import functools
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping

import cv2
import numpy as np
import rosgraph
import rospy
from nav_msgs.msg import Odometry
from sdc_msgs.msg import CarlaVehicleControl, LocalPath, Waypoint
from sensor_msgs.msg import Image

from sdc_common.processes import isolated_ros_environment, wait_until
from sdc_common.ros.node import LoopPublisher
from sdc_sim.ros.picture_messages import image_message

ODOMETRY = "/carla/ego_vehicle/odometry"
PATH = "/planner/local_waypoints"
COMMAND = "/carla/ego_vehicle/vehicle_control_cmd"
IMAGE = "/carla/ego_vehicle/camera/rgb/front/image_color"

_NEWEST = {"queue_size": 1, "tcp_nodelay": True}
_IMAGE_BUFFER_BYTES = 4 * 1024 * 1024
_PATH_POINTS = 25
_TICKS, _TICKS_WITH_PICTURES = 1000, 300
_ANSWER_TIMEOUT_S, _START_TIMEOUT_S = 1.0, 60.0


def perspective_warp() -> Callable[[], np.ndarray]:
    """Return a function that warps a fixed image to (480, 640, 4), always in the same memory."""
    source = np.random.RandomState(0).randint(0, 255, (1024, 1024, 4)).astype(np.uint8)
    target = np.empty((480, 640, 4), np.uint8)
    matrix = np.array([[1.0, 0.1, 3.0], [0.05, 1.1, 2.0], [1e-4, 2e-4, 1.0]])
    return lambda: cv2.warpPerspective(
        source, matrix, (640, 480), dst=target, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    )


class BareWorld:
    """The process that publishes odometry and pictures and waits for commands.

    Raises:
        TimeoutError: a node of the loop is missing
    """

    def __init__(self) -> None:
        self._odometry_publisher = LoopPublisher(ODOMETRY, Odometry)
        self._image_publisher = LoopPublisher(IMAGE, Image)
        self._answered = threading.Event()
        self._warp = perspective_warp()
        rospy.Subscriber(COMMAND, CarlaVehicleControl, lambda _: self._answered.set(), **_NEWEST)
        wait_until(
            lambda: (
                self._odometry_publisher.get_num_connections() == 2
                and self._image_publisher.get_num_connections()
            ),
            _START_TIMEOUT_S,
            "a connection to both nodes of the bare loop",
        )

    def tick_ms(self, pictures: bool) -> float:
        """Return the median time of a tick [ms]; with pictures, each warps and publishes one."""
        times, odometry = [], Odometry()
        for _ in range(_TICKS_WITH_PICTURES if pictures else _TICKS):
            self._answered.clear()
            start = time.perf_counter()
            self._odometry_publisher.publish(odometry)
            if pictures:
                self._image_publisher.publish(image_message(self._warp(), rospy.Time(0)))
            if self._answered.wait(_ANSWER_TIMEOUT_S):
                times.append(time.perf_counter() - start)
        return 1e3 * float(np.median(times))


@contextlib.contextmanager
def _running(*command: str, environment: Mapping[str, str]) -> Iterator[None]:
    """Run a program during a block and interrupt it at the end."""
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(_START_TIMEOUT_S)


@contextlib.contextmanager
def bare_loop() -> Iterator[BareWorld]:
    """Run the loop under a ROS master of its own, of which this process becomes a node."""
    with tempfile.TemporaryDirectory() as name, isolated_ros_environment(name) as environment:
        os.environ.update({key: environment[key] for key in ("ROS_MASTER_URI", "ROS_IP")})
        port = environment["ROS_MASTER_URI"].rsplit(":", 1)[1]
        run = functools.partial(_running, environment=environment)
        node = [sys.executable, "-m", "sdc_experiments.benchmarks.bare_loop"]
        with run("roscore", "-p", port):
            wait_until(rosgraph.is_master_online, _START_TIMEOUT_S, "the ROS master")
            rospy.init_node("bare_world", disable_signals=True)
            with run(*node, "planner"), run(*node, "controller"):
                yield BareWorld()
            rospy.signal_shutdown("all is measured")


def run_node(name: str) -> None:
    """Run a node that answers each message with a constant one, and only receives others."""
    path, command = LocalPath([Waypoint(1.0, 2.0, 3.0)] * _PATH_POINTS), CarlaVehicleControl()
    if name == "planner":
        asked, answered, answer, other = (ODOMETRY, Odometry), PATH, path, (IMAGE, Image)
    else:
        asked, answered, answer, other = (PATH, LocalPath), COMMAND, command, (ODOMETRY, Odometry)
    publisher = LoopPublisher(answered, type(answer))
    rospy.Subscriber(*asked, lambda _: publisher.publish(answer), **_NEWEST)
    rospy.Subscriber(*other, lambda _: None, buff_size=_IMAGE_BUFFER_BYTES, **_NEWEST)
    rospy.spin()


if __name__ == "__main__":
    rospy.init_node(f"bare_{sys.argv[1]}")
    run_node(sys.argv[1])
