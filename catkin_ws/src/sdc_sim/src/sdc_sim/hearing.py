"""Turns the contract's messages into what a Watch knows, whether they come over topics or out of a bag."""
from __future__ import annotations

import math

from sdc_package.odometry import pose_and_speed
from sdc_sim.watch import Watch


class Hearing:
    """One method a topic. Raises ValueError for a message that no drive can be measured by."""

    def __init__(self, watch: Watch):
        self.watch = watch
        self.by_topic = {
            "/planner/mission_waypoints": self.mission,
            "/planner/local_waypoints": self.local_path,
            "/carla/ego_vehicle/odometry": self.odometry,
            "/carla/ego_vehicle/vehicle_control_cmd": self.command,
            "/carla/ego_vehicle/collision": self.collision,
            "/carla/ego_vehicle/obstacles": self.obstacles,
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
        self.watch.command(command.header.stamp.to_nsec(), command.throttle, command.brake, command.steer)

    def local_path(self, path) -> None:
        """sdc_package/LocalPath: its first point is the first that is not behind the car."""
        if path.waypoints and math.isfinite(path.waypoints[0].v):
            self.watch.planned(path.waypoints[0].v)

    def collision(self, event) -> None:
        """sdc_sim/CarlaCollisionEvent."""
        self.watch.collision(event.header.stamp.to_nsec(), event.other_actor_id)

    def obstacles(self, array) -> None:
        """sdc_package/ObstacleArray: what the bodies are that the car may run into."""
        for obstacle in array.obstacles:
            self.watch.obstacle(obstacle.id, obstacle.kind)
