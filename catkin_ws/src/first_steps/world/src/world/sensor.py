"""The car's sensor: which waypoints lie near."""

from __future__ import annotations

import math


def sense(car, waypoints, sensor_range, front_only):
    """The waypoints within `sensor_range` field units of the car, its edge included.

    With `front_only`, those abeam of the car or ahead of it, not those behind.
    """
    ahead_x, ahead_y = math.cos(car.direction), math.sin(car.direction)
    sensed = []
    for waypoint in waypoints:
        dx, dy = waypoint.x - car.x, waypoint.y - car.y
        is_near = dx * dx + dy * dy <= sensor_range * sensor_range
        if is_near and (not front_only or dx * ahead_x + dy * ahead_y >= 0.0):
            sensed.append(waypoint)
    return sensed
