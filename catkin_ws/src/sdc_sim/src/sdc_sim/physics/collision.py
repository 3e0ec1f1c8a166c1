"""Overlap of rectangles on the ground, and the first contact of a moving one with another.

Separating axis theorem (S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, 1996): two oriented
rectangles overlap if and only if their projections on each of the four side directions overlap.
"""

from __future__ import annotations

import math
from typing import Callable, Iterator, NamedTuple

from sdc_common.driving import other_level

# A motion is sampled at this distance; the interval of the contact is then bisected this often.
_STEP_M = 0.2
_BISECTIONS = 30


class Rectangle(NamedTuple):
    """A body seen from above: centre and heading in the map, length along the heading, width."""

    x_m: float
    y_m: float
    yaw_rad: float
    length_m: float
    width_m: float
    z_m: float = math.nan  # height of the ground, NaN if it is not known

    @property
    def reach_m(self) -> float:
        """Distance from the centre to a corner."""
        return 0.5 * math.hypot(self.length_m, self.width_m)

    def grown(self, margin_m: float) -> Rectangle:
        """Return the rectangle with this margin on each side."""
        return self._replace(
            length_m=self.length_m + 2.0 * margin_m, width_m=self.width_m + 2.0 * margin_m
        )

    def corners(self) -> Iterator[tuple[float, float]]:
        """Yield the four corners (x, y), counter-clockwise from the front left one."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        for along, across in ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)):
            ahead, left = along * self.length_m, across * self.width_m
            yield self.x_m + c * ahead - s * left, self.y_m + s * ahead + c * left


class Contact(NamedTuple):
    """The free share of a motion, and the unit normal from the other body to the moving one."""

    share: float
    normal_x: float
    normal_y: float


# The rectangle of a body after a share 0..1 of its motion.
Motion = Callable[[float], Rectangle]


def overlap(a: Rectangle, b: Rectangle) -> tuple[float, float, float] | None:
    """Return how deep `a` is in `b`; None if they are apart, on two levels, or only touch.

    Returns:
        (depth [m], normal x, normal y); the normal is the direction of the shortest way out of b
    """
    if other_level(a.z_m, b.z_m):
        return None
    offset_x, offset_y = a.x_m - b.x_m, a.y_m - b.y_m
    reach = a.reach_m + b.reach_m
    if offset_x * offset_x + offset_y * offset_y >= reach * reach:
        return None
    min_depth = math.inf
    normal_x = normal_y = 0.0
    for yaw in (b.yaw_rad, b.yaw_rad + 0.5 * math.pi, a.yaw_rad, a.yaw_rad + 0.5 * math.pi):
        axis_x, axis_y = math.cos(yaw), math.sin(yaw)
        distance = offset_x * axis_x + offset_y * axis_y
        depth = _half_extent(a, yaw) + _half_extent(b, yaw) - abs(distance)
        if depth <= 0.0:
            return None
        if depth < min_depth:
            min_depth = depth
            side = 1.0 if distance >= 0.0 else -1.0
            normal_x, normal_y = side * axis_x, side * axis_y
    return min_depth, normal_x, normal_y


def _half_extent(body: Rectangle, direction_rad: float) -> float:
    turn = direction_rad - body.yaw_rad
    return 0.5 * (body.length_m * abs(math.cos(turn)) + body.width_m * abs(math.sin(turn)))


def first_contact(motion: Motion, other: Motion) -> Contact | None:
    """Return the first contact of a moving body with another one; None if its path is free.

    The path between the ends is sampled: a body can be neither too thin nor too fast. A body that
    overlaps the other at the start may move as long as the overlap does not get deeper.
    """
    start, end = motion(0.0), motion(1.0)
    other_start, other_end = other(0.0), other(1.0)
    travelled = math.hypot(end.x_m - start.x_m, end.y_m - start.y_m)
    travelled += math.hypot(other_end.x_m - other_start.x_m, other_end.y_m - other_start.y_m)
    if (
        math.hypot(start.x_m - other_start.x_m, start.y_m - other_start.y_m)
        > start.reach_m + other_start.reach_m + travelled
    ):
        return None
    inside = overlap(start, other_start)
    if inside:
        deeper = overlap(end, other_end)
        return Contact(0.0, inside[1], inside[2]) if deeper and deeper[0] > inside[0] else None
    travelled += start.reach_m * abs(end.yaw_rad - start.yaw_rad)
    travelled += other_start.reach_m * abs(other_end.yaw_rad - other_start.yaw_rad)
    steps = max(1, math.ceil(travelled / _STEP_M))
    for step in range(1, steps + 1):
        if overlap(motion(step / steps), other(step / steps)):
            return _bisected(motion, other, (step - 1) / steps, step / steps)
    return None


def _bisected(motion: Motion, other: Motion, free: float, touching: float) -> Contact:
    for _ in range(_BISECTIONS):
        middle = 0.5 * (free + touching)
        if overlap(motion(middle), other(middle)):
            touching = middle
        else:
            free = middle
    contact = overlap(motion(touching), other(touching))
    assert contact is not None
    return Contact(free, contact[1], contact[2])
