"""All topics that the sim node publishes in a tick."""

from __future__ import annotations

import rospy
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from sdc_common.ros.ground_truth import GROUND_TRUTH
from sdc_common.ros.node import LoopPublisher
from sdc_sim.ros.bridge_topics import BridgeTopics
from sdc_sim.ros.message_conversion import odometry_message, vehicle_transform
from sdc_sim.ros.picture_feed import PictureFeed
from sdc_sim.ros.sensor_topics import SensorTopics
from sdc_sim.ros.simulation_setup import SimulationSetup
from sdc_sim.sensors.readings import SensorReadings


class SimulationTopics:
    """Publishes the last observation: the control loop first, then the bridge, then the picture.

    Odometry and clock are published in the caller's thread, and latched for nodes that connect
    later. The sensors are published before the odometry. With `truth: false` they are published
    after it, because then the vehicle's software answers them.
    """

    def __init__(self, setup: SimulationSetup):
        self._simulation = setup.simulation
        self._truth = setup.truth
        self.sensors = SensorTopics(setup.sensors, setup.bridge, setup.role_name)
        odometry = setup.ego + "/odometry" if setup.truth else GROUND_TRUTH
        self.odometry = LoopPublisher(odometry, Odometry, latch=True)
        self._clock = LoopPublisher("/clock", Clock, latch=True)
        self._transform = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self._role_name = setup.role_name
        self._drive_log = setup.drive_log
        self.bridge = BridgeTopics(setup, self.sensors.vehicle_topics)
        self._pictures = None
        if setup.pictures:
            self._pictures = PictureFeed(setup.picture_feed, setup.pictures)

    @property
    def tick_topics(self) -> list[str]:
        """Names of the topics besides `odometry` that a node of the loop needs in a tick."""
        own = [] if self._truth else [f"/carla/{self._role_name}/odometry"]
        return [*self.bridge.tick_topics, *self.sensors.tick_topics, *own]

    @property
    def has_camera(self) -> bool:
        """Whether the camera is ready for a picture, or there is none."""
        return self._pictures is None or self._pictures.is_ready

    def start_clock(self) -> None:
        """Publish the time of the first observation: some nodes wait for it and then subscribe."""
        self._clock.publish(rospy.Time(*self._simulation.snapshot.stamp))

    def publish(self) -> None:
        """Publish all but the picture."""
        observation = self._simulation.snapshot
        stamp = rospy.Time(*observation.stamp)
        # The ground truth has no noise.
        shown = observation.measured if self._truth else observation.state
        odometry = odometry_message(shown, stamp, self._role_name)
        self._drive_log.add_observation(observation, odometry)
        try:
            if self._truth:
                self.sensors.publish(observation.readings, stamp)
            self.odometry.publish(odometry)
            # The observation is older than the clock by the latency of the sensors.
            self._clock.publish(rospy.Time(*self._simulation.stamp))
            if self._truth and self._transform.get_num_connections():
                self._transform.publish([vehicle_transform(odometry)])
            self.bridge.publish()
            if not self._truth:
                self.sensors.publish(observation.readings, stamp)
        except rospy.ROSException:
            # At shutdown rospy closes the topics while this thread still publishes.
            if not rospy.core.is_shutdown_requested():
                raise

    def publish_picture(self, again: bool = False) -> None:
        """Have the camera take and publish the picture of the last observation.

        Args:
            again: whether this repeats the picture, which is not latched
        """
        if self._pictures:
            # The camera needs no readings, which are large with a lidar.
            shown = self._simulation.snapshot._replace(readings=SensorReadings())
            self._pictures.show(shown, again)
