"""The content of the window: the latest data about field, waypoints and car."""

from __future__ import annotations

import math
from collections import deque
from types import SimpleNamespace
from typing import Iterable, NamedTuple

from PyQt5.QtCore import QLineF, QPointF, QRectF
from PyQt5.QtGui import QPolygonF

from qt_interface.settings import WorldSizes


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
        self.trail: deque[QLineF] = deque(maxlen=settings.trail_points)  # steps of the car
        self.car: Pose | None = None
        self._car_before: Pose | None = None
        self._car_time = -math.inf
        self._car_period = 0.0

    @property
    def car_size(self) -> float:
        """Side of the red square [u]."""
        return self.sizes.car_size or self.settings.plain_car_size

    @property
    def walls(self) -> QRectF | None:
        """The field around the origin [u]; None if the world does not set its size."""
        width, height = self.sizes.field_width, self.sizes.field_height
        if width is None or height is None:
            return None
        return QRectF(-width / 2.0, -height / 2.0, width, height)

    def clear_trail(self) -> None:
        """Remove the trail, after a reset of the world."""
        self.trail.clear()

    def set_world(self, sizes: WorldSizes, points: Iterable[Point]) -> None:
        """Set the world's sizes and the waypoints; ignore non-finite points."""
        self.sizes, self.waypoints = sizes, sorted(_finite(points))

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
        step = QLineF(*self.car[:2], x, y) if self.car else None
        is_jump = step is None or step.length() > self.settings.trail_jump
        if not is_jump:
            self.trail.append(step)
        self._car_before = None if is_jump else self.car_at(now)
        self._car_period = min(now - self._car_time, 0.1)
        self.car, self._car_time = Pose(x, y, direction), now

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
        return self.walls is None or self.walls.contains(x, y)

    def extent(self) -> QRectF:
        """Return the area [u] that a view of the whole scene must contain."""
        points = [QPointF(point.x, point.y) for point in self.waypoints]
        if self.walls is None:
            points += [end for step in self.trail for end in (step.p1(), step.p2())]
            points += [QPointF(*self.car[:2])] if self.car else []
        else:
            points += [self.walls.topLeft(), self.walls.bottomRight()]
        return QPolygonF(points).boundingRect()


def _finite(points: Iterable[Point]) -> list[Point]:
    return [point for point in points if math.isfinite(point.x) and math.isfinite(point.y)]
