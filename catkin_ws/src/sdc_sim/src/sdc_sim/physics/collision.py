"""Do two rectangles on the ground touch, how deep, and how far may one of them move before it does?

Separating axis theorem (S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, 1996) for two oriented rectangles: they are apart
exactly when they are apart along one of the four directions of their sides.
"""

from __future__ import annotations

import math
from typing import NamedTuple

# A way is looked at in steps of this length, and the step in which the bodies meet is halved this often.
_STEP_M = 0.2
_HALVINGS = 30


class Rectangle(NamedTuple):
    """A body seen from above: its centre and heading in the map, its length along the heading and its width."""

    x_m: float
    y_m: float
    yaw_rad: float
    length_m: float
    width_m: float

    @property
    def reach_m(self) -> float:
        """From the centre to a corner."""
        return 0.5 * math.hypot(self.length_m, self.width_m)

    def grown(self, margin_m: float) -> Rectangle:
        """The rectangle with this margin on each side."""
        return self._replace(
            length_m=self.length_m + 2.0 * margin_m, width_m=self.width_m + 2.0 * margin_m
        )

    def corners(self):
        """The four corners as (x, y), counter-clockwise from the front left one."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        for along, across in ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)):
            ahead, left = along * self.length_m, across * self.width_m
            yield self.x_m + c * ahead - s * left, self.y_m + s * ahead + c * left


class Contact(NamedTuple):
    """Where a way ends: after this share of it, and the unit vector from the other body towards the one that moves."""

    share: float
    normal_x: float
    normal_y: float


def overlap(a: Rectangle, b: Rectangle):
    """How deep `a` lies in `b`: (depth_m, normal_x, normal_y), the normal being the shortest way out of b; None where they are
    apart. Bodies that share no more than their outline are apart."""
    offset_x, offset_y = a.x_m - b.x_m, a.y_m - b.y_m
    reach = a.reach_m + b.reach_m
    if offset_x * offset_x + offset_y * offset_y >= reach * reach:
        return None
    shallowest = math.inf
    normal_x = normal_y = 0.0
    for yaw in (b.yaw_rad, b.yaw_rad + 0.5 * math.pi, a.yaw_rad, a.yaw_rad + 0.5 * math.pi):
        axis_x, axis_y = math.cos(yaw), math.sin(yaw)
        apart = offset_x * axis_x + offset_y * axis_y
        depth = _half_extent(a, yaw) + _half_extent(b, yaw) - abs(apart)
        if depth <= 0.0:
            return None
        if depth < shallowest:
            shallowest = depth
            side = 1.0 if apart >= 0.0 else -1.0
            normal_x, normal_y = side * axis_x, side * axis_y
    return shallowest, normal_x, normal_y


def _half_extent(body: Rectangle, direction_rad: float) -> float:
    turn = direction_rad - body.yaw_rad
    return 0.5 * (body.length_m * abs(math.cos(turn)) + body.width_m * abs(math.sin(turn)))


def first_contact(way, other: Rectangle) -> Contact | None:
    """Where the body on its way first meets `other`: a Contact whose share of the way is still free; None for a free way.

    way: a function that gives the body (Rectangle) after a share 0..1 of its way. No body is too thin or too fast: the
    way between the ends is looked at too. A body that already lies in the other may move as long as it gets no deeper.
    """
    start, end = way(0.0), way(1.0)
    travelled = math.hypot(end.x_m - start.x_m, end.y_m - start.y_m)
    if (
        math.hypot(start.x_m - other.x_m, start.y_m - other.y_m)
        > start.reach_m + other.reach_m + travelled
    ):
        return None
    inside = overlap(start, other)
    if inside:
        deeper = overlap(end, other)
        return Contact(0.0, inside[1], inside[2]) if deeper and deeper[0] > inside[0] else None
    travelled += start.reach_m * abs(end.yaw_rad - start.yaw_rad)
    steps = max(1, math.ceil(travelled / _STEP_M))
    for step in range(1, steps + 1):
        if overlap(way(step / steps), other):
            return _meeting(way, other, (step - 1) / steps, step / steps)
    return None


def _meeting(way, other: Rectangle, free: float, touching: float) -> Contact:
    for _ in range(_HALVINGS):
        middle = 0.5 * (free + touching)
        if overlap(way(middle), other):
            touching = middle
        else:
            free = middle
    _, normal_x, normal_y = overlap(way(touching), other)
    return Contact(free, normal_x, normal_y)
