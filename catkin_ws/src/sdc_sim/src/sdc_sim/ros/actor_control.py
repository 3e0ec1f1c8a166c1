"""Topics of the CARLA bridge that set the pose and the velocity of the vehicle."""

from __future__ import annotations

from typing import Any, Callable

import rospy
from geometry_msgs.msg import Pose, Twist

from sdc_sim.ros.message_conversion import MAP_FRAME, map_pose
from sdc_sim.ros.request_queue import RequestQueue
from sdc_sim.ros.simulation_setup import SimulationSetup


class ActorControl:
    """Subscribes to the topics of this kind that the generation of the bridge has.

    All changes are requests that the loop executes.

    Args:
        requests: requests to the loop
        setup: the simulation and the generation
        on_change: called in the loop after a change of the simulation
    """

    def __init__(
        self, requests: RequestQueue, setup: SimulationSetup, on_change: Callable[[], None]
    ):
        self._simulation = setup.simulation
        self._on_change = on_change
        handlers: dict[str, tuple[type, Callable[[Any], None]]] = {
            "/control/set_transform": (Pose, self._set_pose),
            "/control/set_target_velocity": (Twist, self._set_velocity),
            "/twist_cmd": (Twist, self._set_velocity),
        }
        for name, (message_class, handle) in handlers.items():
            if name in setup.bridge.topics:
                callback = requests.deferred(self._checked(setup.ego + name, handle))
                rospy.Subscriber(setup.ego + name, message_class, callback, queue_size=1)

    def _checked(self, topic: str, handle: Callable[[Any], None]) -> Callable[[Any], None]:
        def execute(message: Any) -> None:
            try:
                handle(message)
            except ValueError as error:
                rospy.logwarn_throttle(1.0, f"sim: refused a message on {topic}: {error}")
                return
            self._on_change()

        return execute

    def _set_pose(self, pose: Pose) -> None:
        self._simulation.place(*map_pose(MAP_FRAME, pose))

    def _set_velocity(self, twist: Twist) -> None:
        # As in the bridge, a person at the wheel has precedence.
        if not self._simulation.commands.manual_override:
            self._simulation.set_velocity(twist.linear.x, twist.linear.y, twist.angular.z)
