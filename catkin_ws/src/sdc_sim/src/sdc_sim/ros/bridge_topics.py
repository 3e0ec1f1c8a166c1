"""The topics of the CARLA bridge that no tick waits for: what the car is, how it fares, what is around it."""

from __future__ import annotations

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
from sdc_sim.simulation.simulation import Simulation

# What only people look at is published this often in simulated time.
_SLOW_S = 0.2
# That nothing stands on the road is said this often.
_NOTHING_S = 1.0


class BridgeTopics:
    """Publishes them after each tick, and only what somebody listens to: the loop that drives has no time to lose."""

    def __init__(
        self, role_name: str, preset: str, map_name: str, world: Simulation, sync: bool, route_m
    ):
        ego = "/carla/" + role_name
        self.world = world
        self.route_m = route_m
        self.lane_watch = None
        self.slow_ticks = max(1, round(_SLOW_S / world.tick_s))
        self.nothing_ticks = max(1, round(_NOTHING_S / world.tick_s))
        self.shown = set()
        self.told_of_obstacles = False
        self.carla_status = CarlaStatus(
            fixed_delta_seconds=world.tick_s, synchronous_mode=sync, synchronous_mode_running=True
        )

        self.status = rospy.Publisher(ego + "/vehicle_status", CarlaEgoVehicleStatus, queue_size=10)
        self.obstacles = rospy.Publisher(ego + "/obstacles", ObstacleArray, queue_size=10)
        self.collision = rospy.Publisher(ego + "/collision", CarlaCollisionEvent, queue_size=100)
        self.lane_invasion = rospy.Publisher(
            ego + "/lane_invasion", CarlaLaneInvasionEvent, queue_size=100
        )
        self.markers = rospy.Publisher("/carla/markers", MarkerArray, queue_size=10)
        self.world_status = rospy.Publisher("/carla/status", CarlaStatus, queue_size=10, latch=True)
        self.info = rospy.Publisher(
            ego + "/vehicle_info", CarlaEgoVehicleInfo, queue_size=1, latch=True
        )
        self.world_info = rospy.Publisher(
            "/carla/world_info", CarlaWorldInfo, queue_size=1, latch=True
        )

        self.light_info = rospy.Publisher(
            "/carla/traffic_lights/info", CarlaTrafficLightInfoList, queue_size=1, latch=True
        )
        self.light_status = rospy.Publisher(
            "/carla/traffic_lights/status", CarlaTrafficLightStatusList, queue_size=10, latch=True
        )
        self.shown_lamps = None

        self.light_info.publish(light_info_message(world.lights.all, world.sensed.lamps))
        self.info.publish(vehicle_info_message(world.vehicle.parameters, preset, role_name))
        self.world_info.publish(CarlaWorldInfo(map_name=map_name))
        self.show_running(True)

    def show_running(self, running: bool) -> None:
        """Tell whether the world runs or is paused."""
        self.carla_status.frame = self.world.tick
        self.carla_status.synchronous_mode_running = running
        self.world_status.publish(self.carla_status)

    def all_connected(self) -> bool:
        """Whether all who have asked the master for what stands on the road are connected to it."""
        listeners = dict(rospy.get_master().getSystemState()[2][1])
        return all(
            set(listeners.get(topic.resolved_name, ()))
            <= {connection[1] for connection in topic.impl.get_stats_info()}
            for topic in (self.obstacles, self.light_info, self.light_status)
        )

    def publish(self, touches) -> None:
        """Everything about the tick that has just been taken."""
        sensed = self.world.sensed
        stamp = rospy.Time(*sensed.stamp)
        if sensed.lamps != self.shown_lamps:
            self.light_status.publish(light_status_message(sensed.lamps))
            self.shown_lamps = sensed.lamps
        if (
            sensed.bodies
            or sensed.lamps
            or self.told_of_obstacles
            or self.world.tick % self.nothing_ticks == 0
        ) and self.obstacles.get_num_connections():
            self.obstacles.publish(obstacles_message(sensed.bodies, sensed.lamps, stamp))
            self.told_of_obstacles = bool(sensed.bodies)
        if self.status.get_num_connections():
            self.status.publish(status_message(sensed.state, self.world.control.last, stamp))
        for touch in touches:
            self.collision.publish(collision_message(touch, stamp))
        if self.lane_invasion.get_num_connections():
            self.watch_lanes(stamp)
        if self.world.tick % self.slow_ticks == 0:
            self.publish_slowly(sensed, stamp)

    def publish_slowly(self, sensed, stamp) -> None:
        """What people look at; also after a change that the paused world would not show."""
        if self.markers.get_num_connections():
            numbers = {body.id for body in sensed.bodies}
            self.markers.publish(markers_message(sensed.bodies, self.shown - numbers, stamp))
            self.shown = numbers
        if self.world_status.get_num_connections():
            self.show_running(self.carla_status.synchronous_mode_running)

    def watch_lanes(self, stamp) -> None:
        """The lines are looked for from the moment that somebody wants to know."""
        if self.lane_watch is None:
            self.lane_watch = LaneInvasionDetector(Road(self.route_m))
        crossed = self.lane_watch.update(self.world.car)
        if crossed:
            self.lane_invasion.publish(lane_invasion_message(crossed, stamp))

    def car_was_moved(self) -> None:
        """The car has been put somewhere else: it has crossed no line on the way."""
        if self.lane_watch:
            self.lane_watch.reset()
