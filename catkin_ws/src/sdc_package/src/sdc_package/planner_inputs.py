"""Collect the inputs of the local planner that belong to one odometry."""

from __future__ import annotations

import threading
from typing import Any, Callable

import rospy

from sdc_common.ros.conversion import detected_obstacles, stop_lines
from sdc_common.ros.refusal import refusing
from sdc_package.obstacle_prediction import Obstacles
from sdc_package.traffic_lights import TrafficLightMargins, TrafficLightMonitor


class PlannerInputs:
    """Calls `answer(odometry)` once for each odometry, when the obstacles of its time are known.

    While there are obstacles or stamped traffic lights, the world publishes them in every tick,
    with the stamp of the odometry, before or after it. Without them, the odometry does not wait.
    When the next odometry arrives first, it is answered with the last known obstacles. An odometry
    that arrives twice is ignored. A lock serializes the calls of several threads.

    Attributes:
        obstacles: the detected obstacles
        traffic_lights: the known traffic lights
        lock: held during each call of `answer`; hold it to change what `answer` uses
    """

    def __init__(self, answer: Callable[[Any], None], margins: TrafficLightMargins):
        """Collect inputs; `answer` is not called before `start()`."""
        self.obstacles: Obstacles = ()
        self.traffic_lights = TrafficLightMonitor(margins)
        self.lock = threading.RLock()
        self._answer, self._started = answer, False
        self._waiting: Any = None
        self._last_stamp: Any = None
        self._obstacles_stamp = rospy.Time(0)

    def start(self) -> None:
        """Answer the odometry that waits, and each one from now on."""
        with self.lock:
            self._started = True
            self._answer_if_complete()

    def add_odometry(self, odometry: Any) -> None:
        """Add a nav_msgs/Odometry."""
        with self.lock:
            if odometry.header.stamp == self._last_stamp:
                return
            self._last_stamp = odometry.header.stamp
            overdue = self._waiting is not None
            self._waiting = odometry
            self._answer_if_complete(overdue)

    def add_obstacles(self, message: Any) -> None:
        """Add a sdc_msgs/ObstacleArray, with the states of the traffic lights at its time."""
        with self.lock:
            with refusing("/carla/ego_vehicle/obstacles"):
                self.obstacles = detected_obstacles(message)
            if message.traffic_lights or self.traffic_lights.stamped:
                self.traffic_lights.set_states(message.traffic_lights, stamped=True)
            self._obstacles_stamp = message.header.stamp
            self._answer_if_complete()

    def add_light_info(self, message: Any) -> None:
        """Add a CarlaTrafficLightInfoList, which contains the positions of the traffic lights."""
        with self.lock, refusing("/carla/traffic_lights/info"):
            self.traffic_lights.lines = stop_lines(message)

    def add_light_status(self, message: Any) -> None:
        """Add a CarlaTrafficLightStatusList, which has no stamp."""
        with self.lock:
            self.traffic_lights.set_states(message.traffic_lights, stamped=False)

    def _answer_if_complete(self, overdue: bool = False) -> None:
        if self._waiting is None or not self._started:
            return
        expected = self.obstacles or self.traffic_lights.stamped
        if overdue or not expected or self._obstacles_stamp >= self._waiting.header.stamp:
            odometry, self._waiting = self._waiting, None
            self._answer(odometry)
