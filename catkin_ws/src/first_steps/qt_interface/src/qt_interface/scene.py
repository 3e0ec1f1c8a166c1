"""What the window shows: the latest that is known of the field, the points and the car."""

from __future__ import annotations

import math
from typing import NamedTuple

from qt_interface.settings import WorldSizes
from qt_interface.trail import Trail


class Point(NamedTuple):
    """A waypoint; `x`, `y` in field units."""

    idx: int
    x: float
    y: float


class Pose(NamedTuple):
    """The car's place in field units and its direction in radians."""

    x: float
    y: float
    direction: float


def blend(before, after, fraction):
    """The pose `fraction` (0..1) of the way between two; the direction turns the shortest way round."""
    turn = math.remainder(after.direction - before.direction, 2.0 * math.pi)
    return Pose(
        before.x + (after.x - before.x) * fraction,
        before.y + (after.y - before.y) * fraction,
        before.direction + turn * fraction,
    )


def _finite(points):
    return [
        point
        for point in (Point(*p) for p in points)
        if math.isfinite(point.x) and math.isfinite(point.y)
    ]


class Scene:
    """What is shown. Times `now` are seconds on any steady clock."""

    def __init__(self, settings):
        self.settings = settings
        self.sizes = WorldSizes(None, None, None, None, False)
        self.waypoints = []
        self.sensed = frozenset()
        self.target = None
        self.laps = None  # until somebody counts them
        self.is_paused = False
        self.trail = Trail(settings.trail_points, settings.trail_jump)
        self.version = 0  # changes when walls or waypoints do
        self.car = None
        self._car_extent = []  # two corners of the box in which the car has been
        self._car_before = None
        self._car_time = -math.inf
        self._car_period = 0.0

    @property
    def car_size(self):
        """Side of the red square, field units."""
        return self.sizes.car_size or self.settings.plain_car_size

    @property
    def has_walls(self):
        """Whether a world told how large its field is."""
        return bool(self.sizes.field_width and self.sizes.field_height)

    def set_world(self, sizes, points):
        """Takes the world's sizes and the waypoints, (idx, x, y) each; points that are not finite are left out."""
        waypoints = sorted(_finite(points))
        if (sizes, waypoints) != (self.sizes, self.waypoints):
            self.sizes, self.waypoints = sizes, waypoints
            self.version += 1

    def set_sensed(self, points):
        """Takes the points that the sensor reports now."""
        self.sensed = frozenset(_finite(points))

    def set_target(self, point):
        """Takes the point that the driver is heading for; None if it is nowhere."""
        self.target = next(iter(_finite([point])), None)

    def set_car(self, x, y, direction, now):
        """Takes a position of the car that came in at `now`; one that is not finite is ignored."""
        pose = Pose(x, y, direction)
        if not all(math.isfinite(value) for value in pose):
            return
        self._car_before = self.car_at(now)
        if (
            self._car_before
            and math.hypot(x - self._car_before.x, y - self._car_before.y)
            > self.settings.trail_jump
        ):
            self._car_before = None
        self._car_period = min(now - self._car_time, 0.1)
        self.car, self._car_time = pose, now
        self.trail.add(x, y)
        xs, ys = zip((x, y), *self._car_extent)
        self._car_extent = [(min(xs), min(ys)), (max(xs), max(ys))]

    def car_at(self, now):
        """Where to draw the car at `now`: between its last two positions, so that it glides at any frame rate."""
        if self.car is None or self._car_before is None or self._car_period <= 0.0:
            return self.car
        return blend(
            self._car_before,
            self.car,
            min(max((now - self._car_time) / self._car_period, 0.0), 1.0),
        )

    def silence(self, now):
        """Seconds since a position of the car came in."""
        return now - self._car_time

    def contains(self, x, y):
        """Whether the point lies within the walls; without walls all do."""
        return not self.has_walls or (
            abs(x) <= self.sizes.field_width / 2 and abs(y) <= self.sizes.field_height / 2
        )

    def corners(self):
        """The points that a view of everything has to show."""
        points = [(point.x, point.y) for point in self.waypoints]
        if not self.has_walls:
            return points + self._car_extent
        x, y = self.sizes.field_width / 2.0, self.sizes.field_height / 2.0
        return [*points, (-x, -y), (x, y)]
