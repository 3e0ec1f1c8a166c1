"""The car and the field with its four walls: move, bounce and turn."""

from __future__ import annotations

import math
from typing import NamedTuple


def fold(position: float, limit: float) -> tuple[float, bool]:
    """Reflect a position between two mirrors at -limit and +limit, any number of times.

    Args:
        position: coordinate that would be reached without the mirrors
        limit: distance of each mirror from 0, above 0

    Returns:
        The reflected coordinate, and True if the motion is now in the opposite direction. A
        position exactly on a mirror is not reflected yet.
    """
    if -limit <= position <= limit:
        return position, False
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
        """Return the car after a turn on the spot [rad], with a direction within -pi..pi."""
        return self._replace(direction=math.remainder(self.direction + delta_direction, math.tau))


class Field(NamedTuple):
    """The field around the origin, with walls at x = +-width/2 and y = +-height/2 [u].

    The edge of the car bounces, so the car's centre stays half of `car_size` [u] from each wall.
    """

    width: float
    height: float
    car_size: float

    def contains(self, x: float, y: float) -> bool:
        """Return True if the point is within the walls or on them."""
        return abs(x) <= self.width / 2.0 and abs(y) <= self.height / 2.0

    def limits(self) -> tuple[float, float]:
        """Return the largest |x| and |y| of the car's centre [u]."""
        return (self.width - self.car_size) / 2.0, (self.height - self.car_size) / 2.0

    def clamp(self, car: Car) -> Car:
        """Return the car moved to the nearest position inside the walls."""
        x_limit, y_limit = self.limits()
        x, y = min(max(car.x, -x_limit), x_limit), min(max(car.y, -y_limit), y_limit)
        return Car(x, y, car.direction)

    def advance(self, car: Car, distance: float) -> Car:
        """Return the car after a straight move [u], reflected at the walls as light at mirrors."""
        x_limit, y_limit = self.limits()
        x, back_x = fold(car.x + distance * math.cos(car.direction), x_limit)
        y, back_y = fold(car.y + distance * math.sin(car.direction), y_limit)
        direction = car.direction
        if back_x:
            direction = math.pi - direction
        if back_y:
            direction = -direction
        return Car(x, y, math.remainder(direction, math.tau))
