"""Turns the contract's messages into what a Watch knows, whether they come over topics or out of a bag."""

from __future__ import annotations

import math

from sdc_common.ros.odometry import pose_and_speed
from sdc_common.ros.stop_lines import stop_lines
from sdc_sim.evaluation.evaluator import Evaluator


class EvaluatorInput:
    """One method a topic. Raises ValueError for a message that no drive can be measured by."""

    def __init__(self, watch: Evaluator):
        self.watch = watch
        self.by_topic = {
            "/planner/mission_waypoints": self.mission,
            "/planner/local_waypoints": self.local_path,
            "/carla/ego_vehicle/odometry": self.odometry,
            "/carla/ego_vehicle/vehicle_control_cmd": self.command,
            "/carla/ego_vehicle/collision": self.collision,
            "/carla/ego_vehicle/obstacles": self.obstacles,
            "/carla/traffic_lights/info": self.light_info,
            "/carla/traffic_lights/status": self.light_status,
        }

    def mission(self, path) -> None:
        """sdc_package/Path; the first one counts."""
        if self.watch.drive is None:
            self.watch.mission([(point.x, point.y) for point in path.waypoints])

    def odometry(self, odometry) -> bool:
        """nav_msgs/Odometry; returns whether it was news."""
        return self.watch.odometry(odometry.header.stamp.to_nsec(), *pose_and_speed(odometry))

    def command(self, command) -> None:
        """sdc_package/CarlaVehicleControl."""
        self.watch.command(
            command.header.stamp.to_nsec(), command.throttle, command.brake, command.steer
        )

    def local_path(self, path) -> None:
        """sdc_package/LocalPath: its first point is the first that is not behind the car."""
        if path.waypoints and math.isfinite(path.waypoints[0].v):
            self.watch.planned(path.waypoints[0].v)

    def collision(self, event) -> None:
        """sdc_sim/CarlaCollisionEvent."""
        self.watch.collision(event.header.stamp.to_nsec(), event.other_actor_id)

    def obstacles(self, array) -> None:
        """sdc_package/ObstacleArray: what the bodies are that the car may run into, and what the traffic lights show."""
        for obstacle in array.obstacles:
            self.watch.obstacle(obstacle.id, obstacle.kind)
        if array.traffic_lights:
            self.watch.lights(
                array.header.stamp.to_nsec(),
                {light.id: light.state for light in array.traffic_lights},
            )

    def light_info(self, info) -> None:
        """sdc_package/CarlaTrafficLightInfoList: where the stop lines are."""
        self.watch.stop_lines(stop_lines(info))

    def light_status(self, status) -> None:
        """sdc_package/CarlaTrafficLightStatusList, which has no stamp: heard where the world does not say it with one."""
        self.watch.lights(0, {light.id: light.state for light in status.traffic_lights})
