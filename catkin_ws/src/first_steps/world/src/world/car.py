"""The car and the field with its four walls: moving, bouncing, turning."""

from __future__ import annotations

import math
from typing import NamedTuple


def wrap_angle(angle):
    """The same direction within (-pi, pi], radians."""
    wrapped = math.remainder(angle, 2.0 * math.pi)
    return math.pi if wrapped <= -math.pi else wrapped


def fold(position, limit):
    """Where a thing that would be at `position` is when mirrors stand at -limit and +limit, and whether it moves back.

    Any number of reflections is folded at once; a position exactly on a mirror has not been reflected yet.
    """
    if -limit <= position <= limit:
        return position, False
    if limit == 0.0:
        return 0.0, True
    # Unfold the mirrors: along an endless line the true position runs up and down with a period of four limits.
    along = (position + limit) % (4.0 * limit)
    if along <= 2.0 * limit:
        return min(along - limit, limit), False
    return max(3.0 * limit - along, -limit), True


class Car(NamedTuple):
    """The red square: centre `x`, `y` in field units, `direction` in radians, 0 along +x, counter-clockwise."""

    x: float
    y: float
    direction: float

    def turned(self, delta_direction):
        """The car after it turned on the spot by `delta_direction` radians."""
        return self._replace(direction=wrap_angle(self.direction + delta_direction))


class Field(NamedTuple):
    """The field around the origin; the walls stand at x = +-width/2 and y = +-height/2, field units."""

    width: float
    height: float

    def contains(self, x, y):
        """Whether the point lies within the walls or on them."""
        return abs(x) <= self.width / 2.0 and abs(y) <= self.height / 2.0

    def clamp(self, car, car_size):
        """The nearest place to `car` where its square of side `car_size` touches no wall."""
        x_limit, y_limit = (self.width - car_size) / 2.0, (self.height - car_size) / 2.0
        return car._replace(
            x=min(max(car.x, -x_limit), x_limit),
            y=min(max(car.y, -y_limit), y_limit),
            direction=wrap_angle(car.direction),
        )

    def advance(self, car, distance, car_size):
        """The car after it moved `distance` along its direction, bouncing off walls like light off mirrors.

        The square bounces with its edge: its centre keeps half of `car_size` from each wall. All in field units.
        """
        x, back_x = fold(car.x + distance * math.cos(car.direction), (self.width - car_size) / 2.0)
        y, back_y = fold(car.y + distance * math.sin(car.direction), (self.height - car_size) / 2.0)
        direction = car.direction
        if back_x:
            direction = math.pi - direction
        if back_y:
            direction = -direction
        return Car(x, y, wrap_angle(direction))
