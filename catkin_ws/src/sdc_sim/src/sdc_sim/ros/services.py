"""Control of the simulation by people and other nodes: pause, step, reset, poses and clicks."""

from __future__ import annotations

import math
from typing import Any, Callable

import rospy
from geometry_msgs.msg import PointStamped, Pose, PoseWithCovarianceStamped, Twist
from sdc_msgs.srv import SetObstacle
from std_srvs.srv import Trigger

from sdc_common.ros.node import offer_reload
from sdc_common.ros.refusal import refusing
from sdc_common.validation import check_between
from sdc_sim.physics.collision import Rectangle
from sdc_sim.physics.obstacles import KINDS, ObstaclePlan
from sdc_sim.ros.loop_lock import LoopLock
from sdc_sim.ros.message_conversion import MAP_FRAME, map_point, map_pose
from sdc_sim.ros.simulation_setup import SimulationSetup
from sdc_sim.scenario.configuration import checked

_MAX_OBSTACLE_MPS = 100.0


class PauseControl:
    """Counts the ticks that may still be taken: all, or the steps of a paused simulation."""

    def __init__(self) -> None:
        self._ticks = math.inf

    @property
    def paused(self) -> bool:
        """Whether the simulation stops, now or after some steps."""
        return self._ticks < math.inf

    @property
    def waiting(self) -> bool:
        """Whether the next tick has to wait for `resume` or `step`."""
        return self._ticks == 0

    def pause(self) -> None:
        """Pause after the present tick."""
        self._ticks = 0

    def resume(self) -> None:
        """Run."""
        self._ticks = math.inf

    def step(self) -> None:
        """Allow one more tick, then pause; a running simulation pauses after it."""
        self._ticks = self._ticks + 1 if self.paused else 1

    def take(self) -> bool:
        """Return whether the next tick is allowed now, and count it."""
        if self.waiting:
            return False
        self._ticks -= 1
        return True


class SimulationServices:
    """The services of the node, RViz's topics, and those of the bridge that move the vehicle.

    Args:
        lock: the lock of the loop; all changes are made while the loop waits
        setup: the simulation, and the route, whose direction a clicked obstacle gets
        pause: whether the simulation is paused
        on_pause: called after a change of `pause`
        on_change: called after a change of the simulation
    """

    def __init__(
        self,
        lock: LoopLock,
        setup: SimulationSetup,
        pause: PauseControl,
        on_pause: Callable[[], None],
        on_change: Callable[[], None],
    ):
        self._lock = lock
        self._simulation, self._world = setup.simulation, setup.world
        self._simulations = [car.simulation for car in setup.cars]
        self._pause = pause
        self._route = setup.route
        self._clicked_obstacle = setup.values.clicked_obstacle
        self._on_pause = on_pause
        self._on_change = on_change
        for name, change in (
            ("pause", pause.pause),
            ("resume", pause.resume),
            ("step", pause.step),
            ("reset", self._reset),
        ):
            rospy.Service("~" + name, Trigger, self._service(change))
        offer_reload(lock.guarded(self._reload))
        rospy.Service("~set_obstacle", SetObstacle, lock.guarded(self._set_obstacle))
        place = self._simulation.place
        self._subscribe(
            "/initialpose",
            PoseWithCovarianceStamped,
            lambda message: place(*map_pose(message.header.frame_id, message.pose.pose)),
        )
        self._subscribe("/clicked_point", PointStamped, self._on_click)
        if "/control/set_transform" in setup.bridge.topics:
            topic = setup.ego + "/control/set_transform"
            self._subscribe(topic, Pose, lambda pose: place(*map_pose(MAP_FRAME, pose)))
        for name in ("/control/set_target_velocity", "/twist_cmd"):
            if name in setup.bridge.topics:
                self._subscribe(setup.ego + name, Twist, self._set_velocity)

    def _service(self, change: Callable[[], None]) -> Callable[[Any], tuple[bool, str]]:
        def execute(_request: Any) -> tuple[bool, str]:
            change()
            self._on_pause()
            state = "paused" if self._pause.paused else "running"
            return True, f"{state} at tick {self._simulation.tick}"

        return self._lock.guarded(execute)

    def _subscribe(self, topic: str, message_class: type, handle: Callable[[Any], None]) -> None:
        """Have messages change the simulation; one that raises ValueError is refused."""

        def execute(message: Any) -> None:
            with refusing(topic):
                handle(message)
                self._on_change()

        rospy.Subscriber(topic, message_class, self._lock.guarded(execute), queue_size=10)

    def _reset(self) -> None:
        self._world.reset()
        self._on_change()

    def _reload(self) -> None:
        names = ("friction", "side_wind_mps", "odometry_noise")
        values = {name: checked(name, rospy.get_param("~" + name, None)) for name in names}
        for simulation in self._simulations:
            simulation.set_disturbances(**values)
        text = ", ".join(f"{name} {value}" for name, value in values.items())
        rospy.loginfo("sim: from tick %d on: %s", self._simulation.tick, text)

    def _set_obstacle(self, request: Any) -> tuple[int, str]:
        obstacle, number = request.obstacle, request.obstacle.id
        obstacles = self._simulation.obstacles
        try:
            self._check_one_car()
            check_between(0.0, _MAX_OBSTACLE_MPS, speed=obstacle.speed)
            if request.remove:
                obstacles.change(number, None)
            elif number:
                obstacles.change(number, (map_pose(MAP_FRAME, obstacle.pose)[2], obstacle.speed))
            elif obstacle.kind in KINDS:
                plan = ObstaclePlan.stationary(obstacle.kind, *map_pose(MAP_FRAME, obstacle.pose))
                taken = obstacles.at(Rectangle(*plan.points_m[0], plan.yaw_rad, *plan.size_m[:2]))
                if taken:
                    raise ValueError(f"the {taken.kind} {taken.id} is there; choose another place")
                plan = plan.straight_on(plan.yaw_rad, obstacle.speed)
                number = obstacles.add(plan, self._simulation.outline)
            else:
                raise ValueError(f"unknown kind '{obstacle.kind}'; use one of {', '.join(KINDS)}")
        except ValueError as error:
            return 0, str(error)
        if self._pause.waiting:
            self._on_change()
        return number, ""

    def _check_one_car(self) -> None:
        if len(self._simulations) > 1:
            raise ValueError("the obstacles of a world of several cars cannot be changed")

    def _on_click(self, message: PointStamped) -> None:
        self._check_one_car()
        x, y = map_point(message.header.frame_id, message.point)
        heading = self._route.locate(x, y).heading_rad
        plan = ObstaclePlan.stationary(self._clicked_obstacle, x, y, heading)
        change = self._simulation.obstacles.toggle(plan, self._simulation.outline)
        rospy.loginfo("sim: obstacles: %s", change)

    def _set_velocity(self, twist: Twist) -> None:
        # As in the bridge, a person at the wheel has precedence.
        if not self._simulation.commands.manual_override:
            self._simulation.set_velocity(twist.linear.x, twist.linear.y, twist.angular.z)
