"""The topics of the CARLA bridge besides the control loop, in one table."""

from __future__ import annotations

from typing import Any, Callable, Iterable, NamedTuple, Sequence

import rospy
from carla_msgs.msg import (
    CarlaActorList,
    CarlaCollisionEvent,
    CarlaEgoVehicleInfo,
    CarlaEgoVehicleStatus,
    CarlaLaneInvasionEvent,
    CarlaStatus,
    CarlaTrafficLightInfoList,
    CarlaTrafficLightStatusList,
    CarlaWorldInfo,
)
from carla_ros_bridge.msg import EgoVehicleControlInfo
from derived_object_msgs.msg import ObjectArray
from sdc_msgs.msg import ObstacleArray
from std_msgs.msg import Float32, Header, String
from visualization_msgs.msg import Marker, MarkerArray

from sdc_common.ros.node import LoopPublisher
from sdc_sim.road.lane_invasion import LaneInvasionDetector
from sdc_sim.road.opendrive import opendrive
from sdc_sim.road.road import Road
from sdc_sim.ros import bridge_messages
from sdc_sim.ros.bridge_messages import World
from sdc_sim.ros.bridge_versions import BRIDGE_VERSIONS
from sdc_sim.ros.message_conversion import MAP_FRAME, obstacles_message
from sdc_sim.ros.simulation_setup import SimulationSetup

# Period of the topics for people, in simulated time.
_DISPLAY_PERIOD_S = 0.2
# Period of the messages that there is no obstacle.
_NO_OBSTACLE_PERIOD_S = 1.0
_QUEUE_SIZE = 100

# When a topic is published. Latched: a node that connects later receives the last message.
ONCE = "at the start, latched"
CHANGE = "when it changes, latched, in the thread of the loop"
EVENT = "when it happens"
TICK = "in each tick, while it has subscribers"
STATUS = "as TICK, latched"


class Topic(NamedTuple):
    """A row of the table.

    Attributes:
        name: a name without /carla is one of the vehicle
        message_class: class of its messages
        when: when it is published
        make: returns the messages of the last observation
    """

    name: str
    message_class: type
    when: str
    make: Callable[[World], Sequence[Any]]


class BridgeTopics:
    """Publishes an observation after each tick, and the descriptions of vehicle and world once.

    Args:
        setup: the simulation and the names
        others: names of topics that another class publishes
    """

    def __init__(self, setup: SimulationSetup, others: Sequence[str] = ()):
        self._setup = setup
        self._world = World(
            setup.simulation,
            setup.role_name,
            setup.preset,
            setup.map_name,
            opendrive(setup.map_name, setup.route_m),
            setup.lockstep,
        )
        tick_s = setup.simulation.tick_s
        self._display_ticks = max(1, round(_DISPLAY_PERIOD_S / tick_s))
        self._no_obstacle_ticks = max(1, round(_NO_OBSTACLE_PERIOD_S / tick_s))
        self._lane_invasion_detector: LaneInvasionDetector | None = None
        self._marker_ids: set[int] = set()
        self._obstacle_ids: set[int] = set()
        self._last: dict[str, Any] = {}  # messages of the topics that are published on a change
        # Topics that not every bridge has.
        optional = set().union(*(version.topics for version in BRIDGE_VERSIONS.values()))
        left_out = optional - setup.bridge.topics | set(others)
        self._topics = [topic for topic in self._table() if topic.name not in left_out]
        self._publishers = {topic.name: self._publisher(topic) for topic in self._topics}
        # Before the first odometry: a planner does not know otherwise that it has to wait for them.
        self._publish(topic for topic in self._topics if topic.when in (ONCE, CHANGE))

    def _table(self) -> list[Topic]:
        m = bridge_messages
        # The vehicle's own list came with 0.9.5; before, the world's list left the vehicle out.
        has_own_list = "/objects" in self._setup.bridge.topics
        objects = m.all_objects if has_own_list else m.other_objects
        map_class = self._setup.bridge.map_class
        table = [
            Topic("/carla/traffic_lights/info", CarlaTrafficLightInfoList, ONCE, m.light_info),
            Topic("/carla/traffic_lights_info", CarlaTrafficLightInfoList, ONCE, m.light_info),
            Topic("/vehicle_info", CarlaEgoVehicleInfo, ONCE, m.vehicle_info),
            Topic("/carla/world_info", CarlaWorldInfo, ONCE, m.world_info),
            Topic(
                "/carla/traffic_lights/status", CarlaTrafficLightStatusList, CHANGE, m.light_status
            ),
            Topic("/carla/traffic_lights", CarlaTrafficLightStatusList, CHANGE, m.light_status),
            Topic("/obstacles", ObstacleArray, CHANGE, self._obstacles),
            Topic("/vehicle_status", CarlaEgoVehicleStatus, TICK, m.vehicle_status),
            Topic("/collision", CarlaCollisionEvent, EVENT, m.collisions),
            Topic("/lane_invasion", CarlaLaneInvasionEvent, TICK, self._lane_invasion),
            # A client sends one command for each of these messages.
            Topic("/carla/status", CarlaStatus, STATUS, m.world_status),
            Topic("/carla/markers", MarkerArray, TICK, self._markers),
            Topic("/carla/objects", ObjectArray, TICK, objects),
            Topic("/objects", ObjectArray, TICK, m.other_objects),
            Topic("/carla/actor_list", CarlaActorList, TICK, m.actor_list),
            Topic("/carla/vehicle_marker", Marker, TICK, m.object_markers),
            Topic("/carla/marker", Marker, TICK, m.object_markers),
            Topic("/speedometer", Float32, TICK, m.speed),
            Topic("/ego_vehicle_control_info", EgoVehicleControlInfo, TICK, m.control_info),
        ]
        if map_class:
            make = m.map_text if map_class is String else self._map_info
            table.append(Topic("/carla/map", map_class, ONCE, make))
        return table

    def _publisher(self, topic: Topic) -> rospy.Publisher:
        name = topic.name if topic.name.startswith("/carla/") else self._setup.ego + topic.name
        if topic.when == CHANGE:
            return LoopPublisher(name, topic.message_class, latch=True)
        latch = topic.when in (ONCE, STATUS)
        return rospy.Publisher(name, topic.message_class, queue_size=_QUEUE_SIZE, latch=latch)

    @property
    def tick_topics(self) -> list[str]:
        """Names of the topics that a node of the control loop needs in a tick."""
        names = [topic.name for topic in self._topics if topic.when == CHANGE]
        return [self._publishers[name].resolved_name for name in names]

    def publish(self) -> None:
        """Publish the last observation."""
        self._publish(topic for topic in self._topics if topic.when != ONCE)

    def _publish(self, topics: Iterable[Topic]) -> None:
        for topic in topics:
            publisher = self._publishers[topic.name]
            if topic.when in (TICK, STATUS) and not publisher.get_num_connections():
                continue
            for message in topic.make(self._world):
                if topic.when == CHANGE:
                    if message == self._last.get(topic.name):
                        continue
                    self._last[topic.name] = message
                publisher.publish(message)

    def publish_running(self, running: bool) -> None:
        """Publish whether the simulation runs or is paused."""
        self._world.running = running
        self._publishers["/carla/status"].publish(*bridge_messages.world_status(self._world))

    def reset_lane_invasion(self) -> None:
        """Forget the last position: a vehicle that was placed has crossed no line."""
        if self._lane_invasion_detector:
            self._lane_invasion_detector.reset()

    def _map_info(self, world: World) -> list[Any]:
        map_class: Any = self._setup.bridge.map_class
        return [map_class(Header(frame_id=MAP_FRAME), world.map_name, world.opendrive)]

    def _obstacles(self, world: World) -> list[ObstacleArray]:
        """Return obstacles and lights; without any, return nothing most of the time."""
        obstacles, lights = world.snapshot.obstacles, world.snapshot.traffic_lights
        removed, self._obstacle_ids = self._obstacle_ids, {obstacle.id for obstacle in obstacles}
        is_due = world.simulation.tick % self._no_obstacle_ticks == 0
        if not (obstacles or lights or removed or is_due):
            return []
        return [obstacles_message(obstacles, lights, world.header.stamp)]

    def _lane_invasion(self, world: World) -> list[CarlaLaneInvasionEvent]:
        # The lane markings are computed when the topic gets its first subscriber.
        if self._lane_invasion_detector is None:
            self._lane_invasion_detector = LaneInvasionDetector(Road(self._setup.route_m))
        crossed = self._lane_invasion_detector.update(world.simulation.outline)
        return [CarlaLaneInvasionEvent(world.vehicle_header, crossed)] if crossed else []

    def _markers(self, world: World) -> list[MarkerArray]:
        if world.simulation.tick % self._display_ticks:
            return []
        obstacles, header = world.snapshot.obstacles, world.header
        ids = {obstacle.id for obstacle in obstacles}
        removed, self._marker_ids = self._marker_ids - ids, ids
        markers = [
            Marker(header=header, ns="obstacles", id=number, action=Marker.DELETE)
            for number in sorted(removed)
        ]
        markers += [bridge_messages.obstacle_marker(one, header) for one in obstacles]
        return [MarkerArray(markers)]
