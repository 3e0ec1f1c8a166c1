"""All topics that the sim node publishes in a tick."""

from __future__ import annotations

import rospy
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from sdc_common.ros.node import LoopPublisher
from sdc_sim.camera.front_camera import FrontCamera
from sdc_sim.ros.bridge_topics import BridgeTopics
from sdc_sim.ros.message_conversion import odometry_message, vehicle_transform
from sdc_sim.ros.simulation_setup import SimulationSetup


class SimulationTopics:
    """Publishes the last observation: the control loop first, then the bridge, then the picture.

    Odometry and clock are published in the caller's thread, and latched for nodes that connect
    later.
    """

    def __init__(self, setup: SimulationSetup):
        self._simulation = setup.simulation
        self.odometry = LoopPublisher(setup.ego + "/odometry", Odometry, latch=True)
        self._clock = LoopPublisher("/clock", Clock, latch=True)
        self._transform = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self.bridge = BridgeTopics(
            setup.role_name,
            setup.preset,
            setup.map_name,
            setup.simulation,
            setup.lockstep,
            setup.route_m,
        )
        self._camera = None
        if setup.with_camera:
            self._camera = FrontCamera(
                setup.waypoints_path,
                setup.ego + setup.bridge.image_topic,
                setup.ego + setup.bridge.camera_info_topic,
                setup.daylight,
                every_frame=setup.lockstep,
            )

    def start_clock(self) -> None:
        """Publish the time of the first observation: some nodes wait for it and then subscribe."""
        self._clock.publish(rospy.Time(*self._simulation.observation.stamp))

    def publish(self) -> None:
        """Publish all but the picture."""
        observation = self._simulation.observation
        odometry = odometry_message(observation.measured, rospy.Time(*observation.stamp))
        try:
            self.odometry.publish(odometry)
            # The observation is older than the clock by the latency of the sensors.
            self._clock.publish(rospy.Time(*self._simulation.stamp))
            if self._transform.get_num_connections():
                self._transform.publish([vehicle_transform(odometry)])
            self.bridge.publish(observation)
        except rospy.ROSException:
            # At shutdown rospy closes the topics while this thread still publishes.
            if not rospy.core.is_shutdown_requested():
                raise

    def publish_picture(self) -> None:
        """Have the camera take and publish the picture of the last observation."""
        if self._camera:
            self._camera.show(self._simulation.observation)
