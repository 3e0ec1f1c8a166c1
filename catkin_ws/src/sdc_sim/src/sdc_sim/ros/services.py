"""Control of the simulation by people: pause, resume, step, reset, and clicks in RViz."""

from __future__ import annotations

from typing import Any, Callable

import rospy
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped
from std_srvs.srv import Trigger

from sdc_common.ros.node import offer_reload
from sdc_sim.physics.obstacles import ObstaclePlan
from sdc_sim.ros.actor_control import ActorControl
from sdc_sim.ros.message_conversion import map_point, map_pose
from sdc_sim.ros.request_queue import RequestQueue
from sdc_sim.ros.simulation_setup import SimulationSetup
from sdc_sim.simulation.pause import PauseControl


class SimulationServices:
    """The services of the node, and RViz's /initialpose and /clicked_point.

    All changes are requests that the loop executes.

    Args:
        requests: requests to the loop
        setup: the simulation, and the route, whose direction a clicked obstacle gets
        pause: whether the simulation is paused
        on_pause: called in the loop after a change of `pause`
        on_change: called in the loop after a change of the simulation
    """

    def __init__(
        self,
        requests: RequestQueue,
        setup: SimulationSetup,
        pause: PauseControl,
        on_pause: Callable[[], None],
        on_change: Callable[[], None],
    ):
        self._requests = requests
        self._simulation = setup.simulation
        self._pause = pause
        self._route = setup.route
        self._clicked_obstacle = setup.clicked_obstacle
        self._on_pause = on_pause
        self._on_change = on_change
        for name, change in (
            ("pause", pause.pause),
            ("resume", pause.resume),
            ("step", pause.step),
            ("reset", self._reset),
        ):
            rospy.Service("~" + name, Trigger, self._service(change))
        offer_reload(self._reload, requests.call)
        rospy.Subscriber(
            "/initialpose",
            PoseWithCovarianceStamped,
            requests.deferred(self._on_pose),
            queue_size=1,
        )
        rospy.Subscriber(
            "/clicked_point", PointStamped, requests.deferred(self._on_click), queue_size=10
        )
        ActorControl(requests, setup, on_change)

    def _service(self, change: Callable[[], None]) -> Callable[[Any], tuple[bool, str]]:
        def execute() -> tuple[bool, str]:
            change()
            self._on_pause()
            state = "paused" if self._pause.paused else "running"
            return True, f"{state} at tick {self._simulation.tick}"

        return lambda _request: self._requests.call(execute)

    def _reset(self) -> None:
        self._simulation.reset()
        self._on_change()

    def _reload(self) -> None:
        names = ("friction", "side_wind_mps", "odometry_noise")
        values = {name: rospy.get_param("~" + name, None) for name in names}
        self._simulation.set_disturbances(**values)
        text = ", ".join(f"{name} {value}" for name, value in values.items())
        rospy.loginfo("sim: from tick %d on: %s", self._simulation.tick, text)

    def _on_pose(self, message: PoseWithCovarianceStamped) -> None:
        try:
            self._simulation.place(*map_pose(message.header.frame_id, message.pose.pose))
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"sim: refused a pose on /initialpose: {error}")
            return
        self._on_change()

    def _on_click(self, message: PointStamped) -> None:
        try:
            x, y = map_point(message.header.frame_id, message.point)
            heading = self._route.locate(x, y).heading_rad
            change = self._simulation.toggle_obstacle(
                ObstaclePlan.stationary(self._clicked_obstacle, x, y, heading)
            )
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"sim: refused a point on /clicked_point: {error}")
            return
        rospy.loginfo("sim: obstacles: %s", change)
        self._on_change()
