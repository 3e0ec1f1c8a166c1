"""Ranges from a lidar to solid bodies on the ground.

All beams of a column have one direction on the ground, and all beams of a ring have one slope. With
the distance on the ground as the length of a beam, a vertical wall is equally far away for each
ring, and a horizontal face for each column. So most work is done once for each column or ring.

For each body only the columns that can hit it are computed. The columns of all bodies of a kind lie
one after another in one array, which needs few calls of NumPy.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Sequence

import numpy as np

from sdc_sim.sensors.solid_bodies import FAR_M, PlacedBodies

_TURN = 2.0 * np.pi


class RayCaster:
    """Computes the scans of one lidar.

    Args:
        columns: number of columns in a full turn; each is to the left of the one before
        first_rad: direction of column 0, positive to the left of straight ahead
        elevations_rad: angle of each ring above the horizon
        height_m: height of the lidar above the ground
        range_m: largest range
    """

    def __init__(
        self,
        columns: int,
        first_rad: float,
        elevations_rad: np.ndarray,
        height_m: float,
        range_m: float,
    ):
        self.columns = columns
        self._first_rad = first_rad
        self.slopes = np.tan(np.asarray(elevations_rad, float))
        self.height_m = height_m
        self.range_m = range_m
        self._level = not self.slopes.any()
        # Length of a beam for each metre on the ground.
        self._stretch = np.hypot(1.0, self.slopes)[:, None]
        self._step_rad = _TURN / columns
        # Two turns: the columns of a body need no wrapping.
        angles = np.arange(2 * columns) * self._step_rad
        self._cosines, self._sines = np.cos(angles), np.sin(angles)
        with np.errstate(divide="ignore"):
            ground = np.where(self.slopes < 0.0, -height_m / self.slopes, FAR_M)
        self._ground = np.repeat(ground[:, None], 2 * columns, axis=1)

    def cast(
        self, x_m: float, y_m: float, yaw_rad: float, bodies: Sequence[PlacedBodies]
    ) -> np.ndarray:
        """Return the ranges (rings, columns) from a pose in the map, infinite beyond `range_m` [m].

        Args:
            x_m: position of the lidar
            y_m: position of the lidar
            yaw_rad: its direction
            bodies: the bodies
        """
        nearest = self._ground.copy()
        yaw_rad += self._first_rad
        with np.errstate(divide="ignore", invalid="ignore"):
            for one in bodies:
                if len(one):
                    self._cast_bodies(nearest, x_m, y_m, yaw_rad, one)
        count = self.columns
        ranges = np.minimum(nearest[:, :count], nearest[:, count:])
        if not self._level:
            ranges *= self._stretch
        ranges[ranges > self.range_m] = np.inf
        return ranges

    def _cast_bodies(
        self, nearest: np.ndarray, x_m: float, y_m: float, yaw_rad: float, bodies: PlacedBodies
    ) -> None:
        dx, dy = bodies.x_m - x_m, bodies.y_m - y_m
        low, high = bodies.angles(x_m, y_m, dx, dy)
        first = np.ceil((low - yaw_rad) / self._step_rad).astype(np.int64)
        last = np.floor((high - yaw_rad) / self._step_rad).astype(np.int64)
        count = np.minimum(last - first + 1, self.columns)
        first %= self.columns
        # Of each beam that may hit: its body and its column.
        owner = np.repeat(_numbers(len(first)), count)
        if not len(owner):
            return
        column = _numbers(len(owner)) + (first - np.cumsum(count) + count)[owner]
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        cosine, sine = self._cosines[column], self._sines[column]
        east, north = c * cosine - s * sine, s * cosine + c * sine
        rings = None if self._level else self.slopes[:, None]
        enter, leave = bodies.inside(owner, dx, dy, east, north, rings, self.height_m)
        if bodies.bottom_m is not None and bodies.top_m is not None:
            bottom, top = bodies.bottom_m - self.height_m, bodies.top_m - self.height_m
            if rings is None:
                leave = np.where((bottom <= 0.0)[owner] & (top >= 0.0)[owner], leave, -1.0)
            else:
                at_bottom, at_top = bottom[owner] / rings, top[owner] / rings
                enter = np.maximum(enter, np.minimum(at_bottom, at_top))
                leave = np.minimum(leave, np.maximum(at_bottom, at_top))
        # From inside, a body is not visible.
        hits = np.where((enter <= leave) & (enter > 0.0), enter, FAR_M)
        hits = hits.reshape(-1, len(owner))
        start = 0
        for from_column, length in zip(first.tolist(), count.tolist()):
            part = nearest[:, from_column : from_column + length]
            np.minimum(part, hits[:, start : start + length], out=part)
            start += length


@lru_cache(maxsize=None)
def _all_numbers() -> np.ndarray:
    return np.arange(200_000)


def _numbers(count: int) -> np.ndarray:
    numbers = _all_numbers()
    return numbers[:count] if count <= len(numbers) else np.arange(count)
