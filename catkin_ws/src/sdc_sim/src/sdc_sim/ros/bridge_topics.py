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
from derived_object_msgs.msg import Object, ObjectArray
from sdc_msgs.msg import ObstacleArray
from std_msgs.msg import Float32, Header, String
from visualization_msgs.msg import Marker, MarkerArray

from sdc_common.ros.node import LoopPublisher
from sdc_sim.physics.traffic_lights import TrafficLightState
from sdc_sim.road.lane_invasion import LaneInvasionDetector
from sdc_sim.road.opendrive import opendrive
from sdc_sim.road.road import Road
from sdc_sim.ros.bridge_generations import GENERATIONS
from sdc_sim.ros.message_conversion import (
    MAP_FRAME,
    collision_message,
    lane_invasion_message,
    light_info_message,
    light_status_message,
    markers_message,
    obstacles_message,
    status_message,
    vehicle_info_message,
    vehicle_type,
)
from sdc_sim.ros.object_messages import (
    actor_list_message,
    control_info_message,
    ego_object,
    object_array,
    object_marker,
    obstacle_object,
)
from sdc_sim.ros.simulation_setup import SimulationSetup
from sdc_sim.simulation.observation import Observation

# Period of the topics for people, in simulated time.
_DISPLAY_PERIOD_S = 0.2
# Period of the messages that there is no obstacle.
_NO_OBSTACLE_PERIOD_S = 1.0
_EGO_HEIGHT_M = 1.5
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
        make: returns the messages of the present observation
    """

    name: str
    message_class: type
    when: str
    make: Callable[[], Sequence[Any]]


class BridgeTopics:
    """Publishes an observation after each tick, and the descriptions of vehicle and world once.

    Args:
        setup: the simulation and the names
        others: names of topics that another class publishes
    """

    def __init__(self, setup: SimulationSetup, others: Sequence[str] = ()):
        self._setup = setup
        self._simulation = setup.simulation
        self._observation = setup.simulation.observation
        self._lane_invasion_detector: LaneInvasionDetector | None = None
        self._display_ticks = max(1, round(_DISPLAY_PERIOD_S / self._simulation.tick_s))
        self._no_obstacle_ticks = max(1, round(_NO_OBSTACLE_PERIOD_S / self._simulation.tick_s))
        self._marker_ids: set[int] = set()
        self._published_lights: tuple[TrafficLightState, ...] | None = None
        self._published_obstacles: tuple = ((0, 0), (), ())
        self._running = True
        self._publishers: dict[str, rospy.Publisher] = {}
        self._topics: list[Topic] = []
        # Topics that not every bridge has.
        optional = set().union(*(version.topics for version in GENERATIONS.values()))
        missing = optional - setup.bridge.topics
        for topic in self._table():
            if topic.name not in missing and topic.name not in others:
                self._create(topic)
        # Before the first odometry: a planner does not know otherwise that it has to wait for them.
        self._publish(topic for topic in self._topics if topic.when in (ONCE, CHANGE))
        self._published_lights = self._observation.traffic_lights

    def _table(self) -> list[Topic]:
        table = [
            Topic("/carla/traffic_lights/info", CarlaTrafficLightInfoList, ONCE, self._light_info),
            Topic("/carla/traffic_lights_info", CarlaTrafficLightInfoList, ONCE, self._light_info),
            Topic("/vehicle_info", CarlaEgoVehicleInfo, ONCE, self._vehicle_info),
            Topic("/carla/world_info", CarlaWorldInfo, ONCE, self._world_info),
            Topic(
                "/carla/traffic_lights/status", CarlaTrafficLightStatusList, CHANGE, self._lights
            ),
            Topic("/carla/traffic_lights", CarlaTrafficLightStatusList, CHANGE, self._lights),
            Topic("/obstacles", ObstacleArray, CHANGE, self._obstacles),
            Topic("/vehicle_status", CarlaEgoVehicleStatus, TICK, self._status),
            Topic("/collision", CarlaCollisionEvent, EVENT, self._collisions),
            Topic("/lane_invasion", CarlaLaneInvasionEvent, TICK, self._lane_invasion),
            # A client sends one command for each of these messages.
            Topic("/carla/status", CarlaStatus, STATUS, self._world_status),
            Topic("/carla/markers", MarkerArray, TICK, self._markers),
            Topic("/carla/objects", ObjectArray, TICK, self._world_objects),
            Topic("/objects", ObjectArray, TICK, lambda: [self._object_array(self._others())]),
            Topic("/carla/actor_list", CarlaActorList, TICK, self._actor_list),
            Topic("/carla/vehicle_marker", Marker, TICK, self._object_markers),
            Topic("/carla/marker", Marker, TICK, self._object_markers),
            Topic("/speedometer", Float32, TICK, self._speed),
            Topic("/ego_vehicle_control_info", EgoVehicleControlInfo, TICK, self._control_info),
        ]
        if self._setup.bridge.map_class:
            table.append(Topic("/carla/map", self._setup.bridge.map_class, ONCE, self._map))
        return table

    def _create(self, topic: Topic) -> None:
        name = topic.name if topic.name.startswith("/carla/") else self._setup.ego + topic.name
        if topic.when == CHANGE:
            publisher: rospy.Publisher = LoopPublisher(name, topic.message_class, latch=True)
        else:
            latch = topic.when in (ONCE, STATUS)
            publisher = rospy.Publisher(
                name, topic.message_class, queue_size=_QUEUE_SIZE, latch=latch
            )
        self._publishers[topic.name] = publisher
        self._topics.append(topic)

    @property
    def tick_topics(self) -> list[str]:
        """Names of the topics that a node of the control loop needs in a tick."""
        return [
            self._publishers[topic.name].resolved_name
            for topic in self._topics
            if topic.when == CHANGE
        ]

    def publish(self, observation: Observation) -> None:
        """Publish an observation."""
        self._observation = observation
        self._publish(topic for topic in self._topics if topic.when != ONCE)
        self._published_lights = observation.traffic_lights

    def _publish(self, topics: Iterable[Topic]) -> None:
        for topic in topics:
            publisher = self._publishers[topic.name]
            if topic.when not in (TICK, STATUS) or publisher.get_num_connections():
                for message in topic.make():
                    publisher.publish(message)

    def publish_running(self, running: bool) -> None:
        """Publish whether the simulation runs or is paused."""
        self._running = running
        self._publishers["/carla/status"].publish(*self._world_status())

    def reset_lane_invasion(self) -> None:
        """Forget the last position: a vehicle that was placed has crossed no line."""
        if self._lane_invasion_detector:
            self._lane_invasion_detector.reset()

    @property
    def _stamp(self) -> rospy.Time:
        return rospy.Time(*self._observation.stamp)

    def _light_info(self) -> list[CarlaTrafficLightInfoList]:
        lights = self._observation.traffic_lights
        return [light_info_message(self._simulation.lights.plans, lights)]

    def _vehicle_info(self) -> list[CarlaEgoVehicleInfo]:
        parameters = self._simulation.vehicle.parameters
        return [vehicle_info_message(parameters, self._setup.preset, self._setup.role_name)]

    def _opendrive(self) -> str:
        return opendrive(self._setup.map_name, self._setup.route_m)

    def _world_info(self) -> list[CarlaWorldInfo]:
        return [CarlaWorldInfo(self._setup.map_name, self._opendrive())]

    def _map(self) -> list[Any]:
        map_class: Any = self._setup.bridge.map_class
        if map_class is String:
            return [String(self._opendrive())]
        header = Header(frame_id=MAP_FRAME)
        return [map_class(header, self._setup.map_name, self._opendrive())]

    def _lights(self) -> list[CarlaTrafficLightStatusList]:
        lights = self._observation.traffic_lights
        return [light_status_message(lights)] if lights != self._published_lights else []

    def _obstacles(self) -> list[ObstacleArray]:
        """Return obstacles and lights; without any, return nothing most of the time."""
        observed = self._observation
        shown = observed.stamp, observed.obstacles, observed.traffic_lights
        if observed.obstacles or observed.traffic_lights:
            is_new = shown != self._published_obstacles
        else:
            removed = self._published_obstacles[1]
            is_new = removed or self._simulation.tick % self._no_obstacle_ticks == 0
        if not is_new:
            return []
        self._published_obstacles = shown
        return [obstacles_message(observed.obstacles, observed.traffic_lights, self._stamp)]

    def _status(self) -> list[CarlaEgoVehicleStatus]:
        executed = self._simulation.commands.executed
        return [status_message(self._observation.state, executed, self._stamp)]

    def _collisions(self) -> list[CarlaCollisionEvent]:
        frame = self._setup.role_name
        return [collision_message(one, self._stamp, frame) for one in self._observation.collisions]

    def _lane_invasion(self) -> list[CarlaLaneInvasionEvent]:
        # The lane markings are computed when the topic gets its first subscriber.
        if self._lane_invasion_detector is None:
            self._lane_invasion_detector = LaneInvasionDetector(Road(self._setup.route_m))
        crossed = self._lane_invasion_detector.update(self._simulation.outline)
        if not crossed:
            return []
        return [lane_invasion_message(crossed, self._stamp, self._setup.role_name)]

    def _world_status(self) -> list[CarlaStatus]:
        return [
            CarlaStatus(
                frame=self._simulation.tick,
                fixed_delta_seconds=self._simulation.tick_s,
                synchronous_mode=self._setup.lockstep,
                synchronous_mode_running=self._running,
            )
        ]

    def _markers(self) -> list[MarkerArray]:
        if self._simulation.tick % self._display_ticks:
            return []
        ids = {obstacle.id for obstacle in self._observation.obstacles}
        removed, self._marker_ids = self._marker_ids - ids, ids
        return [markers_message(self._observation.obstacles, removed, self._stamp)]

    def _others(self) -> list[Object]:
        age = self._simulation.tick
        return [obstacle_object(one, self._stamp, age) for one in self._observation.obstacles]

    def _own_and_others(self) -> list[Object]:
        parameters, age = self._simulation.vehicle.parameters, self._simulation.tick
        own = ego_object(self._observation.state, parameters, _EGO_HEIGHT_M, self._stamp, age)
        return [own, *self._others()]

    def _object_array(self, objects: list[Object]) -> ObjectArray:
        return object_array(objects, self._stamp)

    def _world_objects(self) -> list[ObjectArray]:
        # The vehicle's own list came with 0.9.5; before, the world's list left the vehicle out.
        has_own_list = "/objects" in self._publishers
        return [self._object_array(self._own_and_others() if has_own_list else self._others())]

    def _object_markers(self) -> list[Marker]:
        return [object_marker(one) for one in self._own_and_others()]

    def _actor_list(self) -> list[CarlaActorList]:
        observed = self._observation
        names = vehicle_type(self._setup.preset), self._setup.role_name
        return [actor_list_message(*names, observed.obstacles, observed.traffic_lights)]

    def _speed(self) -> list[Float32]:
        return [Float32(self._observation.state.speed_mps)]

    def _control_info(self) -> list[EgoVehicleControlInfo]:
        commands = self._simulation.commands
        return [
            control_info_message(
                self._observation.state,
                commands.executed,
                commands.ackermann_target,
                self._simulation.vehicle.parameters,
                commands.ackermann_gains,
                self._stamp,
            )
        ]
