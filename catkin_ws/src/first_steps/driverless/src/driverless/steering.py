"""How far to turn, now, to get to a point."""

from __future__ import annotations

import math


def wrap_angle(angle):
    """The same direction within (-pi, pi], radians: the shortest way round."""
    wrapped = math.remainder(angle, 2.0 * math.pi)
    return math.pi if wrapped <= -math.pi else wrapped


def clamp(value, limit):
    """The value within -limit..limit."""
    return min(max(value, -limit), limit)


def heading_error(x, y, direction, target_x, target_y):
    """From where the car looks to where the target lies, radians within (-pi, pi], positive to the left.

    0 when the car stands on the target.
    """
    if x == target_x and y == target_y:
        return 0.0
    return wrap_angle(math.atan2(target_y - y, target_x - x) - direction)


def needs_run_up(
    was_running_up, x, y, direction, target_x, target_y, turning_radius, reach_distance
):
    """Whether to drive straight on for now, since a car that turned would circle the target for ever.

    A car that turns as sharply as it can runs on a circle beside it, and never comes near a target well inside that
    circle. Once it runs up it does so until the target is outside: with a single limit it would dither on the edge.
    The circle may pass the target at 0.8 of `reach_distance`, no more, since the car is seen at steps only.
    All lengths in field units.
    """
    side = math.copysign(1.0, heading_error(x, y, direction, target_x, target_y))
    centre_x = x - side * turning_radius * math.sin(direction)
    centre_y = y + side * turning_radius * math.cos(direction)
    distance = math.hypot(target_x - centre_x, target_y - centre_y)
    return distance < (turning_radius if was_running_up else turning_radius - 0.8 * reach_distance)
