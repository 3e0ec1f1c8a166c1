"""The car and the field with its four walls: move, bounce and turn."""

from __future__ import annotations

import math
from typing import NamedTuple


def wrap_angle(angle: float) -> float:
    """Return the same direction within (-pi, pi] [rad]."""
    wrapped = math.remainder(angle, 2.0 * math.pi)
    return math.pi if wrapped <= -math.pi else wrapped


def fold(position: float, limit: float) -> tuple[float, bool]:
    """Reflect a position between two mirrors at -limit and +limit.

    Args:
        position: coordinate that would be reached without the mirrors
        limit: distance of each mirror from 0

    Returns:
        The reflected coordinate, and True if the motion is now in the opposite direction. Any
        number of reflections is possible; a position exactly on a mirror is not reflected yet.
    """
    if -limit <= position <= limit:
        return position, False
    if limit == 0.0:
        return 0.0, True
    # Without mirrors the coordinate grows; with them it goes up and down with period 4 * limit.
    along = (position + limit) % (4.0 * limit)
    if along <= 2.0 * limit:
        return min(along - limit, limit), False
    return max(3.0 * limit - along, -limit), True


class Car(NamedTuple):
    """The red square: centre `x`, `y` [u] and `direction` [rad], 0 along +x, counter-clockwise."""

    x: float
    y: float
    direction: float

    def turned(self, delta_direction: float) -> Car:
        """Return the car after a turn on the spot by `delta_direction` [rad]."""
        return self._replace(direction=wrap_angle(self.direction + delta_direction))


class Field(NamedTuple):
    """The field around the origin, with walls at x = +-width/2 and y = +-height/2 [u]."""

    width: float
    height: float

    def contains(self, x: float, y: float) -> bool:
        """Return True if the point is within the walls or on them."""
        return abs(x) <= self.width / 2.0 and abs(y) <= self.height / 2.0

    def clamp(self, car: Car, car_size: float) -> Car:
        """Return the car moved to the nearest position where its square touches no wall.

        Args:
            car: the car, anywhere
            car_size: side of its square [u]
        """
        x_limit, y_limit = (self.width - car_size) / 2.0, (self.height - car_size) / 2.0
        return car._replace(
            x=min(max(car.x, -x_limit), x_limit),
            y=min(max(car.y, -y_limit), y_limit),
            direction=wrap_angle(car.direction),
        )

    def advance(self, car: Car, distance: float, car_size: float) -> Car:
        """Return the car after a straight move, reflected at the walls as light at mirrors.

        Args:
            car: the car before the move
            distance: length of the move [u]
            car_size: side of the square [u]; its edge bounces, so its centre stays half of it from
                each wall
        """
        x, back_x = fold(car.x + distance * math.cos(car.direction), (self.width - car_size) / 2.0)
        y, back_y = fold(car.y + distance * math.sin(car.direction), (self.height - car_size) / 2.0)
        direction = car.direction
        if back_x:
            direction = math.pi - direction
        if back_y:
            direction = -direction
        return Car(x, y, wrap_angle(direction))
