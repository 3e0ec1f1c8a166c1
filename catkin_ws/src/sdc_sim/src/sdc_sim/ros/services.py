"""What a person does to the world from outside: pause it, step it, put it back, move the car, put things on the road."""

from __future__ import annotations

import rospy
from geometry_msgs.msg import PointStamped, PoseWithCovarianceStamped
from std_srvs.srv import Trigger

from sdc_sim.physics.obstacles import ObstaclePlan
from sdc_sim.simulation.placement import checked_point, checked_pose


class SimulationServices:
    """The services ~pause, ~resume, ~step and ~reset, and RViz's /initialpose and /clicked_point.

    `sim` is the node: its lock, world, pace, route and topics are used, and its go_on_if_answered, keep and publish called.
    """

    def __init__(self, sim, clicked_obstacle: str):
        self.sim = sim
        self.clicked_obstacle = clicked_obstacle
        for name, change in (
            ("pause", sim.pace.pause),
            ("resume", sim.pace.resume),
            ("step", sim.pace.step),
            ("reset", self.reset),
        ):
            rospy.Service("~" + name, Trigger, self.service(change))
        rospy.Subscriber("/initialpose", PoseWithCovarianceStamped, self.on_pose, queue_size=1)
        rospy.Subscriber("/clicked_point", PointStamped, self.on_click, queue_size=10)

    def service(self, change):
        """A service that makes a change and tells how the world stands after it."""

        def answer(_request):
            with self.sim.lock:
                change()
                self.sim.go_on_if_answered()
                self.sim.topics.show_running(not self.sim.pace.paused)
                self.sim.keep()
                return (
                    True,
                    f"{'paused' if self.sim.pace.paused else 'running'} at tick {self.sim.world.tick}",
                )

        return answer

    def reset(self):
        self.sim.world.reset()
        self.show_change()

    def on_pose(self, message):
        with self.sim.lock:
            try:
                self.sim.world.place(*checked_pose(message.header.frame_id, message.pose.pose))
            except ValueError as error:
                rospy.logwarn_throttle(1.0, f"sim: refused a pose on /initialpose: {error}")
                return
            self.show_change()

    def on_click(self, message):
        with self.sim.lock:
            try:
                x, y = checked_point(message.header.frame_id, message.point)
                heading = self.sim.route.locate(x, y).heading_rad
                done = self.sim.world.toggle_obstacle(
                    ObstaclePlan.standing(self.clicked_obstacle, x, y, heading)
                )
            except ValueError as error:
                rospy.logwarn_throttle(1.0, f"sim: refused a point on /clicked_point: {error}")
                return
            rospy.loginfo("sim: obstacles: %s", done)
            self.show_change()

    def show_change(self):
        """A paused world shows at once what has been changed in it."""
        self.sim.topics.car_was_moved()
        if self.sim.pace.waiting:
            self.sim.world.look_again()
            self.sim.publish([])
        self.sim.keep()
