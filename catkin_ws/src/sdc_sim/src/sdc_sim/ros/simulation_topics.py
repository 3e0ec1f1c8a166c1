"""All topics that the sim node publishes in a tick."""

from __future__ import annotations

import rospy
from carla_msgs.msg import CarlaWeatherParameters
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

from sdc_common.ros.ground_truth import GROUND_TRUTH
from sdc_common.ros.node import LoopPublisher
from sdc_sim.camera.front_camera import FrontCamera
from sdc_sim.ros.bridge_topics import BridgeTopics
from sdc_sim.ros.message_conversion import odometry_message, vehicle_transform
from sdc_sim.ros.object_messages import daylight, spectator_mount
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
        self._camera = None
        if setup.with_camera:
            self._camera = FrontCamera(
                setup.waypoints_path,
                setup.role_name,
                setup.bridge,
                setup.daylight,
                every_frame=setup.lockstep,
                weather=setup.weather,
            )
            self._subscribe(setup)

    def _subscribe(self, setup: SimulationSetup) -> None:
        """Subscribe to what changes the pictures."""
        if "/carla/weather_control" in setup.bridge.topics:
            rospy.Subscriber(
                "/carla/weather_control", CarlaWeatherParameters, self._on_weather, queue_size=1
            )
        if setup.bridge.spectator:
            rospy.Subscriber(
                setup.ego + "/spectator_pose", PoseStamped, self._on_spectator, queue_size=1
            )

    def _on_weather(self, message: CarlaWeatherParameters) -> None:
        try:
            brightness = daylight(message.sun_altitude_angle)
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"sim: refused a message on weather_control: {error}")
            return
        if self._camera:
            self._camera.daylight = brightness

    def _on_spectator(self, message: PoseStamped) -> None:
        try:
            mount = spectator_mount(message, self._role_name)
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"sim: refused a pose on spectator_pose: {error}")
            return
        if self._camera:
            self._camera.spectator = mount

    @property
    def tick_topics(self) -> list[str]:
        """Names of the topics besides `odometry` that a node of the loop needs in a tick."""
        own = [] if self._truth else [f"/carla/{self._role_name}/odometry"]
        return [*self.bridge.tick_topics, *self.sensors.tick_topics, *own]

    def start_clock(self) -> None:
        """Publish the time of the first observation: some nodes wait for it and then subscribe."""
        self._clock.publish(rospy.Time(*self._simulation.observation.stamp))

    def publish(self) -> None:
        """Publish all but the picture."""
        observation = self._simulation.observation
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
            self.bridge.publish(observation)
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
        if self._camera:
            # The camera needs no readings, which are large with a lidar.
            shown = self._simulation.observation._replace(readings=SensorReadings())
            self._camera.show(shown, again)
