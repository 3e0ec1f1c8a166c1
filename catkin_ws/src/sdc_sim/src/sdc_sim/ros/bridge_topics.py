"""The topics of the CARLA bridge besides the control loop: status, events, obstacles, lights."""

from __future__ import annotations

import numpy as np
import rospy
from carla_msgs.msg import (
    CarlaCollisionEvent,
    CarlaEgoVehicleInfo,
    CarlaEgoVehicleStatus,
    CarlaLaneInvasionEvent,
    CarlaStatus,
    CarlaTrafficLightInfoList,
    CarlaTrafficLightStatusList,
    CarlaWorldInfo,
)
from sdc_msgs.msg import ObstacleArray
from visualization_msgs.msg import MarkerArray

from sdc_common.ros.node import LoopPublisher
from sdc_sim.physics.traffic_lights import TrafficLightState
from sdc_sim.road.lane_invasion import LaneInvasionDetector
from sdc_sim.road.road import Road
from sdc_sim.ros.message_conversion import (
    collision_message,
    lane_invasion_message,
    light_info_message,
    light_status_message,
    markers_message,
    obstacles_message,
    status_message,
    vehicle_info_message,
)
from sdc_sim.simulation.observation import Observation
from sdc_sim.simulation.simulation import Simulation

# Period of the topics for people, in simulated time.
_DISPLAY_PERIOD_S = 0.2
# Period of the messages that there is no obstacle.
_NO_OBSTACLE_PERIOD_S = 1.0


class BridgeTopics:
    """Publishes an observation after each tick, and the descriptions of vehicle and world once.

    Obstacles and traffic lights are latched: a node that connects later receives those of the
    present tick. Topics that are not latched are published only if they have subscribers.

    Args:
        role_name: name of the vehicle in its topics
        preset: name of the vehicle preset
        map_name: name of the map
        simulation: the simulation
        lockstep: whether it runs in lockstep
        route_m: (N, 2) points of the route
        opendrive: the map as OpenDRIVE
    """

    def __init__(
        self,
        role_name: str,
        preset: str,
        map_name: str,
        simulation: Simulation,
        lockstep: bool,
        route_m: np.ndarray,
        opendrive: str,
    ):
        self._simulation = simulation
        self._vehicle_frame = role_name
        self._route_m = route_m
        self._lane_invasion_detector: LaneInvasionDetector | None = None
        self._display_ticks = max(1, round(_DISPLAY_PERIOD_S / simulation.tick_s))
        self._no_obstacle_ticks = max(1, round(_NO_OBSTACLE_PERIOD_S / simulation.tick_s))
        self._marker_ids: set[int] = set()
        self._published_lights: tuple[TrafficLightState, ...] | None = None
        self._published_obstacles: tuple = ((0, 0), (), ())
        self._carla_status = CarlaStatus(
            fixed_delta_seconds=simulation.tick_s,
            synchronous_mode=lockstep,
            synchronous_mode_running=True,
        )
        self._create_publishers("/carla/" + role_name)
        states = simulation.observation.traffic_lights
        self.light_info.publish(light_info_message(simulation.lights.plans, states))
        self._info.publish(vehicle_info_message(simulation.vehicle.parameters, preset, role_name))
        self._world_info.publish(CarlaWorldInfo(map_name, opendrive))
        # Before the first odometry: a planner does not know otherwise that it has to wait for them.
        self._publish_surroundings(simulation.observation)

    def _create_publishers(self, ego: str) -> None:
        def latched(topic: str, message_class: type, queue_size: int = 1) -> rospy.Publisher:
            return rospy.Publisher(topic, message_class, queue_size=queue_size, latch=True)

        self.obstacles = LoopPublisher(ego + "/obstacles", ObstacleArray, latch=True)
        self.light_info = latched("/carla/traffic_lights/info", CarlaTrafficLightInfoList)
        self.light_status = latched(
            "/carla/traffic_lights/status", CarlaTrafficLightStatusList, queue_size=10
        )
        self._status = rospy.Publisher(
            ego + "/vehicle_status", CarlaEgoVehicleStatus, queue_size=10
        )
        self._collision = rospy.Publisher(ego + "/collision", CarlaCollisionEvent, queue_size=100)
        self._lane_invasion = rospy.Publisher(
            ego + "/lane_invasion", CarlaLaneInvasionEvent, queue_size=100
        )
        self._markers = rospy.Publisher("/carla/markers", MarkerArray, queue_size=10)
        self._world_status = latched("/carla/status", CarlaStatus, queue_size=10)
        self._info = latched(ego + "/vehicle_info", CarlaEgoVehicleInfo)
        self._world_info = latched("/carla/world_info", CarlaWorldInfo)

    @property
    def tick_topics(self) -> list[str]:
        """Names of the topics that a node of the control loop needs in a tick."""
        publishers = (self.obstacles, self.light_info, self.light_status)
        return [publisher.resolved_name for publisher in publishers]

    def publish_running(self, running: bool) -> None:
        """Publish whether the simulation runs or is paused."""
        self._carla_status.frame = self._simulation.tick
        self._carla_status.synchronous_mode_running = running
        self._world_status.publish(self._carla_status)

    def publish(self, observation: Observation) -> None:
        """Publish an observation."""
        stamp = rospy.Time(*observation.stamp)
        self._publish_surroundings(observation)
        if self._status.get_num_connections():
            executed = self._simulation.commands.executed
            self._status.publish(status_message(observation.state, executed, stamp))
        for event in observation.collisions:
            self._collision.publish(collision_message(event, stamp, self._vehicle_frame))
        if self._lane_invasion.get_num_connections():
            self._publish_lane_invasion(stamp)
        # A client sends one command for each of these messages.
        if self._world_status.get_num_connections():
            self.publish_running(self._carla_status.synchronous_mode_running)
        if self._simulation.tick % self._display_ticks == 0:
            self._publish_display(observation, stamp)

    def _publish_surroundings(self, observation: Observation) -> None:
        stamp, obstacles, lights = (
            observation.stamp,
            observation.obstacles,
            observation.traffic_lights,
        )
        if lights != self._published_lights:
            self.light_status.publish(light_status_message(lights))
            self._published_lights = lights
        if obstacles or lights:
            news = (stamp, obstacles, lights) != self._published_obstacles
        else:
            removed = self._published_obstacles[1]
            news = removed or self._simulation.tick % self._no_obstacle_ticks == 0
        if news:
            self.obstacles.publish(obstacles_message(obstacles, lights, rospy.Time(*stamp)))
            self._published_obstacles = stamp, obstacles, lights

    def _publish_display(self, observation: Observation, stamp: rospy.Time) -> None:
        if self._markers.get_num_connections():
            ids = {obstacle.id for obstacle in observation.obstacles}
            removed = self._marker_ids - ids
            self._markers.publish(markers_message(observation.obstacles, removed, stamp))
            self._marker_ids = ids

    def _publish_lane_invasion(self, stamp: rospy.Time) -> None:
        # The lane markings are computed when the topic gets its first subscriber.
        if self._lane_invasion_detector is None:
            self._lane_invasion_detector = LaneInvasionDetector(Road(self._route_m))
        crossed = self._lane_invasion_detector.update(self._simulation.outline)
        if crossed:
            message = lane_invasion_message(crossed, stamp, self._vehicle_frame)
            self._lane_invasion.publish(message)

    def reset_lane_invasion(self) -> None:
        """Forget the last position: a vehicle that was placed has crossed no line."""
        if self._lane_invasion_detector:
            self._lane_invasion_detector.reset()
