"""The car's sensor: find the waypoints near the car."""

from __future__ import annotations

import math
from typing import Iterable

from world.car import Car
from world.waypoints import Waypoint


def sense(
    car: Car, waypoints: Iterable[Waypoint], sensor_range: float, front_only: bool
) -> list[Waypoint]:
    """Return the waypoints that the sensor detects.

    Args:
        car: position and direction of the car
        waypoints: all waypoints
        sensor_range: largest distance from the car's centre, inclusive [u]
        front_only: True to leave out the points behind the car
    """
    ahead_x, ahead_y = math.cos(car.direction), math.sin(car.direction)
    sensed = []
    for waypoint in waypoints:
        dx, dy = waypoint.x - car.x, waypoint.y - car.y
        is_near = dx * dx + dy * dy <= sensor_range * sensor_range
        if is_near and (not front_only or dx * ahead_x + dy * ahead_y >= 0.0):
            sensed.append(waypoint)
    return sensed
