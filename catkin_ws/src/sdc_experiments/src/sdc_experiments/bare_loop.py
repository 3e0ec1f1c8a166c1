"""The driving loop without algorithms: three processes that only exchange messages with rospy.

Its time per tick is the lower limit of a lockstep tick. This module runs one of its two nodes:

python3 -m sdc_experiments.bare_loop planner|controller
"""

from __future__ import annotations

import sys
import threading
import time
from typing import Callable

import numpy as np
import rospy
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl, LocalPath, Waypoint
from sensor_msgs.msg import Image

from sdc_common.ros.node import LoopPublisher
from sdc_common.testing.message_listener import wait_until
from sdc_sim.ros.message_conversion import image_message

ODOMETRY = "/carla/ego_vehicle/odometry"
PATH = "/planner/local_waypoints"
COMMAND = "/carla/ego_vehicle/vehicle_control_cmd"
IMAGE = "/carla/ego_vehicle/camera/rgb/front/image_color"

_NEWEST = {"queue_size": 1, "tcp_nodelay": True}
_IMAGE_BUFFER_BYTES = 4 * 1024 * 1024
_PATH_POINTS = 25
_ANSWER_TIMEOUT_S = 1.0


class BareWorld:
    """The process that publishes odometry and pictures and waits for commands."""

    def __init__(self) -> None:
        """Connect to both nodes.

        Raises:
            TimeoutError: a node is missing
        """
        self.odometry_publisher = LoopPublisher(ODOMETRY, Odometry)
        self.image_publisher = LoopPublisher(IMAGE, Image)
        self.answered = threading.Event()
        rospy.Subscriber(COMMAND, CarlaVehicleControl, self._on_command, **_NEWEST)
        wait_until(
            lambda: (
                self.odometry_publisher.get_num_connections() == 2
                and self.image_publisher.get_num_connections()
            ),
            60.0,
            "a connection to both nodes of the bare loop",
        )

    def _on_command(self, _command: CarlaVehicleControl) -> None:
        self.answered.set()

    def tick_ms(self, ticks: int, render: Callable[[], np.ndarray] | None = None) -> float:
        """Return the median time of a tick [ms].

        Args:
            ticks: number of ticks to measure
            render: returns the picture to publish in each tick, None for no pictures
        """
        times = []
        odometry = Odometry()
        for _ in range(ticks):
            self.answered.clear()
            start = time.perf_counter()
            self.odometry_publisher.publish(odometry)
            if render:
                self.image_publisher.publish(image_message(render(), rospy.Time(0)))
            if self.answered.wait(_ANSWER_TIMEOUT_S):
                times.append(time.perf_counter() - start)
        return 1e3 * float(np.median(times))


def run_planner() -> None:
    """Answer each odometry with a constant path, and receive pictures."""
    path = LocalPath([Waypoint(1.0, 2.0, 3.0)] * _PATH_POINTS)
    publisher = LoopPublisher(PATH, LocalPath)
    rospy.Subscriber(ODOMETRY, Odometry, lambda _: publisher.publish(path), **_NEWEST)
    rospy.Subscriber(IMAGE, Image, lambda _: None, buff_size=_IMAGE_BUFFER_BYTES, **_NEWEST)
    rospy.spin()


def run_controller() -> None:
    """Answer each path with a constant command, and receive odometry."""
    command = CarlaVehicleControl()
    publisher = LoopPublisher(COMMAND, CarlaVehicleControl)
    rospy.Subscriber(ODOMETRY, Odometry, lambda _: None, **_NEWEST)
    rospy.Subscriber(PATH, LocalPath, lambda _: publisher.publish(command), **_NEWEST)
    rospy.spin()


NODES = {"planner": run_planner, "controller": run_controller}


def main() -> None:
    """Run the node that the command line names."""
    role = sys.argv[1] if len(sys.argv) > 1 else ""
    if role not in NODES:
        sys.exit(__doc__)
    rospy.init_node(f"bare_{role}")
    NODES[role]()


if __name__ == "__main__":
    main()
