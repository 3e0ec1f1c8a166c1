"""All topics that the sim node publishes: the table, and when each of them is published."""

from __future__ import annotations

import os
from typing import Any, Callable, Sequence, Tuple

import rospy
import tf2_ros
from carla_msgs import msg as carla
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from roslib.message import get_message_class
from sdc_msgs.msg import ObstacleArray
from sensor_msgs.msg import Imu, JointState, LaserScan, NavSatFix, PointCloud2
from std_msgs.msg import Float32, Header, String
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from sdc_common.ros.node import LoopPublisher
from sdc_common.ros.odometry import GROUND_TRUTH, vehicle_transform
from sdc_sim.road.lane_invasion import LaneInvasionDetector
from sdc_sim.road.opendrive import opendrive, opendrive_file
from sdc_sim.ros import bridge_messages
from sdc_sim.ros.bridge_messages import World
from sdc_sim.ros.bridge_versions import BRIDGE_VERSIONS
from sdc_sim.ros.message_conversion import (
    MAP_FRAME,
    gnss_message,
    imu_message,
    odometry_message,
    point_cloud_message,
    scan_message,
    wheel_speeds_message,
)
from sdc_sim.ros.picture_feed import PictureFeed
from sdc_sim.ros.simulation_setup import SimulationSetup
from sdc_sim.scenario.configuration import part_of_map
from sdc_sim.sensors.model import MOUNTS_M, SensorReadings
from sdc_sim.yaml_document import packaged_config

# Period of the topics for people, in simulated time.
_DISPLAY_PERIOD_S = 0.2
# Period of the messages that there is no obstacle.
_NO_OBSTACLE_PERIOD_S = 1.0
_QUEUE_SIZE = 100

# When a topic is published, see config/topics.yaml.
ONCE, CHANGE, TICK, STATUS = "once", "change", "tick", "status"

# By their names in config/sim.yaml: field of the readings, message class, and what returns the
# message of a reading, the settings and a header. The wheel speeds are last: nodes use a tick's
# readings then.
_SENSORS: dict[str, tuple[str, type, Callable[..., Any]]] = {
    "imu": ("imu", Imu, imu_message),
    "gnss": ("gnss", NavSatFix, gnss_message),
    "speedometer": ("speed_mps", Float32, lambda speed_mps, *_: Float32(speed_mps)),
    "lidar": ("lidar", PointCloud2, point_cloud_message),
    "planar_lidar": ("planar_lidar", PointCloud2, point_cloud_message),
    "wheel_speeds": ("wheel_speeds_radps", JointState, wheel_speeds_message),
}
# Class of the messages, when they are published, and what returns those of the last observation.
Topic = Tuple[Any, str, Callable[[World], Sequence[Any]]]


class SimulationTopics:
    """Publishes the last observation: the control loop first, then the bridge, then the picture.

    Odometry and clock are published in the caller's thread, and latched for nodes that connect
    later. The sensors are published before the odometry. With `truth: false` they are published
    after it, because then the vehicle's software answers them.
    """

    def __init__(self, setup: SimulationSetup):
        self._setup = setup
        self._simulation = setup.simulation
        values, names = setup.values, (setup.values.role_name, setup.values.vehicle)
        self._world = World(setup.simulation, *names, values.sync, id=setup.number)
        tick_s = setup.simulation.tick_s
        self._display_ticks = max(1, round(_DISPLAY_PERIOD_S / tick_s))
        self._no_obstacle_ticks = max(1, round(_NO_OBSTACLE_PERIOD_S / tick_s))
        self.lane_invasions = part_of_map(
            "road.network_markings", setup.values.map_path
        ) or LaneInvasionDetector(setup.route)
        self._obstacle_ids: set[int] = set()
        self._last: dict[str, Any] = {}  # messages of the topics that are published on a change
        self._sensors = self._sensor_rows()
        self.odometry_topic = setup.ego + "/odometry" if setup.values.truth else GROUND_TRUTH
        self._odometry = None
        if setup.shows_truth:
            self._odometry = LoopPublisher(self.odometry_topic, Odometry, latch=True)
        self._clock = LoopPublisher("/clock", Clock, latch=True) if setup.number == 1 else None
        self._clock_ns = 0  # the last time on it, which never goes back
        self._transform = rospy.Publisher("/tf", TFMessage, queue_size=10)
        # Topics that not every bridge has, and those of sensors that are on.
        optional = set().union(*(version.topics for version in BRIDGE_VERSIONS.values()))
        measured = {setup.bridge.sensors[name].topic for name in setup.sensors}
        left_out = optional - setup.bridge.topics | measured
        self._topics = self._table(left_out)
        self._publishers = {
            name: self._publisher(name, message_class, when)
            for name, (message_class, when, _) in self._topics.items()
        }
        # Before the first odometry: a planner does not know otherwise that it has to wait for them.
        self._publish(ONCE, CHANGE)
        self._pictures = None
        if setup.pictures:
            self._pictures = PictureFeed(setup.values.picture_feed, setup.pictures)

    def _sensor_rows(self) -> list[tuple[str, Callable[..., Any], Any, str, LoopPublisher]]:
        """Return field, converter, settings, frame and topic of each sensor that is on."""
        rows, transforms = [], []
        for name, (field, message_class, convert) in _SENSORS.items():
            if name not in self._setup.sensors:
                continue
            names = self._setup.bridge.sensors[name]
            frame = self._setup.values.role_name + names.frame
            publisher = LoopPublisher(self._setup.ego + names.topic, message_class, latch=True)
            rows.append((field, convert, self._setup.sensors[name], frame, publisher))
            if name in MOUNTS_M:
                place = Transform(Vector3(*MOUNTS_M[name]), Quaternion(0.0, 0.0, 0.0, 1.0))
                header = Header(frame_id=self._setup.values.role_name)
                transforms.append(TransformStamped(header, frame, place))
            if name == "planar_lidar":
                scans = LoopPublisher(self._setup.ego + "/scan", LaserScan, latch=True)
                rows.append((field, scan_message, self._setup.sensors[name], frame, scans))
        if transforms:
            self._static_tf = tf2_ros.StaticTransformBroadcaster()
            self._static_tf.sendTransform(transforms)
        return rows

    def _publish_readings(self) -> None:
        for field, convert, settings, frame, publisher in self._sensors:
            reading = getattr(self._world.snapshot.readings, field)
            # The same reading in a second form, for those who want it.
            unwanted = convert is scan_message and not publisher.get_num_connections()
            if reading is not None and not unwanted:
                publisher.publish(convert(reading, settings, self._world.header(frame)))

    def _table(self, left_out: set[str]) -> dict[str, Topic]:
        """Return the topics of config/topics.yaml that are published, by name."""
        bridge = self._setup.bridge
        # The vehicle's own list came with 0.9.5; before, the world's list left the vehicle out.
        objects = bridge_messages.other_objects
        if "/objects" in bridge.topics:
            objects = bridge_messages.all_objects
        path = self._setup.values.map_path or self._setup.values.waypoints_path
        map_name = os.path.basename(path).partition(".")[0]
        map_text = opendrive_file(path) or opendrive(map_name, self._setup.route_m)
        if bridge.map_class is String:
            road = String(map_text)
        elif bridge.map_class:
            road = bridge.map_class(Header(frame_id=MAP_FRAME), map_name, map_text)
        own: dict[str, Callable[[World], Sequence[Any]]] = {
            "/carla/world_info": lambda _: [carla.CarlaWorldInfo(map_name, map_text)],
            "/obstacles": self._obstacles,
            "/lane_invasion": self._lane_invasion,
            "/carla/markers": self._markers,
            "/carla/objects": objects,
            "/speedometer": lambda world: [Float32(world.snapshot.state.speed_mps)],
            "/carla/map": lambda _: [road],
        }
        table = {}
        for name, row in packaged_config("topics").items():
            is_of_world = name.startswith("/carla/")  # the first car publishes them
            if name in left_out or (is_of_world and self._setup.number > 1):
                continue
            if row.get("secret") and not self._setup.shows_truth:
                continue
            message_class = get_message_class(row["type"]) if "type" in row else bridge.map_class
            if message_class is not None:
                make = own.get(name) or getattr(bridge_messages, row["of"])
                table[name] = message_class, row["when"], make
        return table

    def _publisher(self, name: str, message_class: type, when: str) -> rospy.Publisher:
        name = name if name.startswith("/carla/") else self._setup.ego + name
        if when == CHANGE:
            return LoopPublisher(name, message_class, latch=True)
        latch = when in (ONCE, STATUS)
        return rospy.Publisher(name, message_class, queue_size=_QUEUE_SIZE, latch=latch)

    @property
    def tick_topics(self) -> list[str]:
        """Names of the topics besides `odometry_topic` that a node of the loop needs in a tick."""
        publishers = [publisher for *_, publisher in self._sensors]
        publishers += [
            self._publishers[name] for name, (_, when, _) in self._topics.items() if when == CHANGE
        ]
        own = [] if self._setup.values.truth else [self._setup.ego + "/odometry"]
        return [*(publisher.resolved_name for publisher in publishers), *own]

    @property
    def has_camera(self) -> bool:
        """Whether the camera is ready for a picture, or there is none."""
        return self._pictures is None or self._pictures.is_ready

    def start_clock(self) -> None:
        """Publish the time of the first observation: some nodes wait for it and then subscribe."""
        if self._clock:
            self._clock.publish(rospy.Time(0, self._simulation.snapshot.stamp_ns))

    def publish_clock(self, since_tick_s: float = 0.0) -> None:
        """Publish the time of the last tick, or a later one before the next tick."""
        if self._clock:
            # A pause may begin between two ticks, and a change publishes the last tick again.
            now_ns = self._simulation.stamp_ns + round(since_tick_s * 1e9)
            self._clock_ns = max(self._clock_ns, now_ns)
            self._clock.publish(rospy.Time(0, self._clock_ns))

    def publish(self) -> None:
        """Publish all but the picture."""
        observation, truth = self._simulation.snapshot, self._setup.values.truth
        # The ground truth has no noise.
        shown = observation.measured if truth else observation.state
        stamp = rospy.Time(0, observation.stamp_ns)
        slope = observation.z_m, observation.pitch_rad
        odometry = odometry_message(shown, stamp, self._setup.values.role_name, *slope)
        if self._setup.drive_log:
            self._setup.drive_log.add_observation(observation, odometry)
        if truth:
            self._publish_readings()
        if self._odometry:
            self._odometry.publish(odometry)
        # The observation is older than the clock by the latency of the sensors.
        self.publish_clock()
        if truth and self._transform.get_num_connections():
            self._transform.publish([vehicle_transform(odometry)])
        self._publish(CHANGE, TICK, STATUS)
        if not truth:
            self._publish_readings()

    def publish_picture(self, again: bool = False) -> None:
        """Have the camera take and publish the picture of the last observation, maybe again."""
        if self._pictures:
            # The camera needs no readings, which are large with a lidar.
            shown = self._simulation.snapshot._replace(readings=SensorReadings())
            self._pictures.show(shown, again)

    def publish_running(self, running: bool) -> None:
        """Publish whether the simulation runs or is paused."""
        self._world.running = running
        self._publishers["/carla/status"].publish(*bridge_messages.world_status(self._world))

    def _publish(self, *selected: str) -> None:
        for name, (_, when, make) in self._topics.items():
            publisher = self._publishers[name]
            if when not in selected:
                continue
            if when in (TICK, STATUS) and not publisher.get_num_connections():
                continue
            for message in make(self._world):
                if when == CHANGE:
                    if message == self._last.get(name):
                        continue
                    self._last[name] = message
                publisher.publish(message)

    def _obstacles(self, world: World) -> list[ObstacleArray]:
        """Return obstacles and lights; without any, return nothing most of the time."""
        obstacles, lights = world.snapshot.obstacles, world.snapshot.traffic_lights
        removed, self._obstacle_ids = self._obstacle_ids, {obstacle.id for obstacle in obstacles}
        is_due = world.simulation.tick % self._no_obstacle_ticks == 0
        return bridge_messages.obstacles(world) if obstacles or lights or removed or is_due else []

    def _lane_invasion(self, world: World) -> list[carla.CarlaLaneInvasionEvent]:
        crossed = self.lane_invasions.update(world.simulation.outline)
        event = carla.CarlaLaneInvasionEvent(world.header(world.role_name), crossed)
        return [event] if crossed else []

    def _markers(self, world: World) -> list[MarkerArray]:
        if world.simulation.tick % self._display_ticks:
            return []
        # A person may have removed an obstacle.
        markers = [Marker(header=world.header(), ns="obstacles", action=Marker.DELETEALL)]
        obstacles = world.snapshot.obstacles
        markers += [bridge_messages.obstacle_marker(world, obstacle) for obstacle in obstacles]
        return [MarkerArray(markers)]
