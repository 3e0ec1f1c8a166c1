"""The content of the window: the latest data about field, waypoints and car."""

from __future__ import annotations

import math
from typing import Iterable, NamedTuple

from qt_interface.settings import Settings, WorldSizes
from qt_interface.trail import Trail


class Point(NamedTuple):
    """A waypoint with its number, at `x`, `y` [u]."""

    idx: int
    x: float
    y: float


class Pose(NamedTuple):
    """The car's position `x`, `y` [u] and its `direction` [rad]."""

    x: float
    y: float
    direction: float


def blend(before: Pose, after: Pose, fraction: float) -> Pose:
    """Return the pose at `fraction` (0..1) between two poses, turning the shortest way round."""
    turn = math.remainder(after.direction - before.direction, 2.0 * math.pi)
    return Pose(
        before.x + (after.x - before.x) * fraction,
        before.y + (after.y - before.y) * fraction,
        before.direction + turn * fraction,
    )


def _finite(points: Iterable[tuple[int, float, float]]) -> list[Point]:
    return [
        point
        for point in (Point(*values) for values in points)
        if math.isfinite(point.x) and math.isfinite(point.y)
    ]


class Scene:
    """The data to draw. Arguments `now` are times in seconds of one monotonic clock."""

    def __init__(self, settings: Settings):
        self.settings = settings
        self.sizes = WorldSizes(None, None, None, None, False)
        self.waypoints: list[Point] = []
        self.sensed: frozenset[Point] = frozenset()
        self.target: Point | None = None
        self.laps: int | None = None  # None until a lap count is received
        self.is_paused = False
        self.trail = Trail(settings.trail_points, settings.trail_jump)
        self.version = 0  # changes with walls and waypoints
        self.car: Pose | None = None
        # Two corners of the smallest box around all positions of the car
        self._car_extent: list[tuple[float, float]] = []
        self._car_before: Pose | None = None
        self._car_time = -math.inf
        self._car_period = 0.0

    @property
    def car_size(self) -> float:
        """Side of the red square [u]."""
        return self.sizes.car_size or self.settings.plain_car_size

    @property
    def has_walls(self) -> bool:
        """True if the world sets the size of its field."""
        return bool(self.sizes.field_width and self.sizes.field_height)

    def set_world(self, sizes: WorldSizes, points: Iterable[tuple[int, float, float]]) -> None:
        """Set the world's sizes and the waypoints (idx, x, y) [u]; ignore non-finite points."""
        waypoints = sorted(_finite(points))
        if (sizes, waypoints) != (self.sizes, self.waypoints):
            self.sizes, self.waypoints = sizes, waypoints
            self.version += 1

    def set_sensed(self, points: Iterable[tuple[int, float, float]]) -> None:
        """Set the points (idx, x, y) [u] that the sensor detects now."""
        self.sensed = frozenset(_finite(points))

    def set_target(self, point: tuple[int, float, float]) -> None:
        """Set the driver's target (idx, x, y) [u]; remove it if the point is not finite."""
        self.target = next(iter(_finite([point])), None)

    def set_car(self, x: float, y: float, direction: float, now: float) -> None:
        """Set the car's pose; ignore one that is not finite.

        Args:
            x: position [u]
            y: position [u]
            direction: direction [rad]
            now: time at which the pose was received [s]
        """
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

    def car_at(self, now: float) -> Pose | None:
        """Return the pose to draw at `now`, interpolated between the last two for smooth motion."""
        if self.car is None or self._car_before is None or self._car_period <= 0.0:
            return self.car
        return blend(
            self._car_before,
            self.car,
            min(max((now - self._car_time) / self._car_period, 0.0), 1.0),
        )

    def car_age(self, now: float) -> float:
        """Return the time since the last pose of the car was received [s]."""
        return now - self._car_time

    def contains(self, x: float, y: float) -> bool:
        """Return True if the point [u] is within the walls, or if there are no walls."""
        if self.sizes.field_width is None or self.sizes.field_height is None:
            return True
        return abs(x) <= self.sizes.field_width / 2 and abs(y) <= self.sizes.field_height / 2

    def corners(self) -> list[tuple[float, float]]:
        """Return the points (x, y) [u] that a view of the whole scene must contain."""
        points = [(point.x, point.y) for point in self.waypoints]
        if self.sizes.field_width is None or self.sizes.field_height is None:
            return points + self._car_extent
        x, y = self.sizes.field_width / 2.0, self.sizes.field_height / 2.0
        return [*points, (-x, -y), (x, y)]
