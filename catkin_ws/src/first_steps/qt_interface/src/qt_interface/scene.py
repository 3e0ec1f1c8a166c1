"""The content of the window: the latest data about field, waypoints and car."""

from __future__ import annotations

import math
from collections import deque
from itertools import islice
from types import SimpleNamespace
from typing import Iterable, NamedTuple

from qt_interface.settings import WorldSizes

PIECE = 125  # positions; a trail of 10,000 has 80 pieces, enough to fade without visible steps


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


class Scene:
    """The data to draw. Arguments `now` are times in seconds of one monotonic clock."""

    def __init__(self, settings: SimpleNamespace):
        """Create an empty scene; `settings` are those of `qt_interface.settings`."""
        self.settings = settings
        self.sizes = WorldSizes()
        self.waypoints: list[Point] = []
        self.sensed: list[Point] = []
        self.target: Point | None = None
        self.is_paused = False
        self.version = 0  # changes with walls and waypoints, and when the trail is cleared
        self.trail: deque[tuple[float, float]] = deque(maxlen=settings.trail_points)
        self.trail_count = 0  # positions since the start
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
    def walls(self) -> tuple[float, float] | None:
        """Largest |x| and |y| of the field [u]; None if the world does not set its size."""
        if self.sizes.field_width is None or self.sizes.field_height is None:
            return None
        return self.sizes.field_width / 2.0, self.sizes.field_height / 2.0

    def trail_pieces(self) -> list[list[tuple[float, float]]]:
        """Return the finished pieces of the trail, oldest first, which never change.

        A piece begins at the end of the previous one.
        """
        points = list(self.trail)
        end = len(points) - 1 - self.trail_count % PIECE
        starts = range(end - PIECE, -PIECE, -PIECE)
        return [points[max(start, 0) : start + PIECE + 1] for start in starts][::-1]

    def newest_trail(self) -> list[tuple[float, float]]:
        """Return the newest piece of the trail: a frame draws only this one again."""
        begin = max(len(self.trail) - 1 - self.trail_count % PIECE, 0)
        return list(islice(self.trail, begin, None))

    def clear_trail(self) -> None:
        """Remove the trail, after a reset of the world."""
        self.trail.clear()
        self.version += 1

    def set_world(self, sizes: WorldSizes, points: Iterable[Point]) -> None:
        """Set the world's sizes and the waypoints; ignore non-finite points."""
        waypoints = sorted(_finite(points))
        if (sizes, waypoints) != (self.sizes, self.waypoints):
            self.sizes, self.waypoints = sizes, waypoints
            self.version += 1

    def set_sensed(self, points: Iterable[Point]) -> None:
        """Set the points that the sensor detects now."""
        self.sensed = sorted(set(_finite(points)))

    def set_target(self, point: Point) -> None:
        """Set the driver's target; remove it if the point is not finite."""
        self.target = next(iter(_finite([point])), None)

    def set_car(self, x: float, y: float, direction: float, now: float) -> None:
        """Set the car's pose; ignore one that is not finite.

        Args:
            x: position [u]
            y: position [u]
            direction: direction [rad]
            now: time at which the pose was received [s]
        """
        if not all(math.isfinite(value) for value in (x, y, direction)):
            return
        self._car_before = self.car_at(now)
        if self._car_before and math.dist(self._car_before[:2], (x, y)) > self.settings.trail_jump:
            self._car_before = None
        self._car_period = min(now - self._car_time, 0.1)
        self.car, self._car_time = Pose(x, y, direction), now
        self.trail.append((x, y))
        self.trail_count += 1
        xs, ys = zip((x, y), *self._car_extent)
        self._car_extent = [(min(xs), min(ys)), (max(xs), max(ys))]

    def car_at(self, now: float) -> Pose | None:
        """Return the pose to draw at `now`, interpolated between the last two for smooth motion."""
        before, car = self._car_before, self.car
        if car is None or before is None or self._car_period <= 0.0:
            return car
        fraction = min(max((now - self._car_time) / self._car_period, 0.0), 1.0)
        turn = math.remainder(car.direction - before.direction, math.tau)
        return Pose(
            before.x + (car.x - before.x) * fraction,
            before.y + (car.y - before.y) * fraction,
            before.direction + turn * fraction,
        )

    def car_age(self, now: float) -> float:
        """Return the time since the last pose of the car was received [s]."""
        return now - self._car_time

    def contains(self, x: float, y: float) -> bool:
        """Return True if the point [u] is within the walls, or if there are no walls."""
        return self.walls is None or (abs(x) <= self.walls[0] and abs(y) <= self.walls[1])

    def corners(self) -> list[tuple[float, float]]:
        """Return the points (x, y) [u] that a view of the whole scene must contain."""
        points = [(point.x, point.y) for point in self.waypoints]
        if self.walls is None:
            return points + self._car_extent
        x, y = self.walls
        return [*points, (-x, -y), (x, y)]


def _finite(points: Iterable[Point]) -> list[Point]:
    return [point for point in points if math.isfinite(point.x) and math.isfinite(point.y)]
