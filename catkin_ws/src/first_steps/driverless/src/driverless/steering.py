"""The geometry of steering: how far to turn to get to a point."""

from __future__ import annotations

import math


def wrap_angle(angle: float) -> float:
    """Return the same direction within (-pi, pi] [rad], the shortest way round."""
    wrapped = math.remainder(angle, 2.0 * math.pi)
    return math.pi if wrapped <= -math.pi else wrapped


def clamp(value: float, limit: float) -> float:
    """Return the value limited to -limit..limit."""
    return min(max(value, -limit), limit)


def heading_error(x: float, y: float, direction: float, target_x: float, target_y: float) -> float:
    """Return the angle from the car's direction to the direction of the target.

    Args:
        x: position of the car [u]
        y: position of the car [u]
        direction: direction of the car [rad]
        target_x: position of the target [u]
        target_y: position of the target [u]

    Returns:
        Angle within (-pi, pi], positive to the left [rad]; 0 if the car is on the target.
    """
    if x == target_x and y == target_y:
        return 0.0
    return wrap_angle(math.atan2(target_y - y, target_x - x) - direction)


def needs_run_up(
    was_running_up: bool,
    x: float,
    y: float,
    direction: float,
    target_x: float,
    target_y: float,
    turning_radius: float,
    reach_distance: float,
) -> bool:
    """Return True if the car must drive straight on before it can turn to the target.

    A car that turns as sharply as it can drives on a circle next to it, and never reaches a target
    well inside that circle. A run-up begins when the target is inside by more than 0.8 of
    `reach_distance` (not all of it, because the car is observed only at its steps). It ends when
    the target is outside. The two limits differ so that the car does not switch at every step.

    Args:
        was_running_up: the result of the previous step
        x: position of the car [u]
        y: position of the car [u]
        direction: direction of the car [rad]
        target_x: position of the target [u]
        target_y: position of the target [u]
        turning_radius: radius of the sharpest turn [u]
        reach_distance: a point at most this far away is reached [u]
    """
    side = math.copysign(1.0, heading_error(x, y, direction, target_x, target_y))
    centre_x = x - side * turning_radius * math.sin(direction)
    centre_y = y + side * turning_radius * math.cos(direction)
    distance = math.hypot(target_x - centre_x, target_y - centre_y)
    return distance < (turning_radius if was_running_up else turning_radius - 0.8 * reach_distance)
