"""Lidars of the vehicle: one with 16 rings on the roof, and a planar one at the front.

All beams of a column have one direction on the ground, and all beams of a ring have one slope. With
the distance on the ground as the length of a beam, a vertical wall is equally far away for each
ring, and a horizontal face for each column. So most work is done once for each column or ring.

For each body only the columns that can hit it are computed. The columns of all bodies of a kind lie
one after another in one array, which needs few calls of NumPy.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Sequence

import numpy as np

from sdc_sim.road.scenery import ROOF_BEYOND_EAVES_M
from sdc_sim.sensors.model import (
    MOUNTS_M,
    Moment,
    SensorContext,
    SensorModel,
    SensorSettings,
    error_sizes,
)
from sdc_sim.sensors.solid_bodies import (
    FAR_M,
    Bodies,
    Rays,
    angles,
    moving_bodies,
    near,
    scenery_bodies,
)

_TURN = 2.0 * np.pi


# Share of the light that is lost for each metre, as CARLA's default.
_LOSS_PER_M = 0.004
# Added to the number of the sensor for the noise of the beams.
_BEAM_STREAM = 128


class LidarModel(SensorModel):
    """A lidar that takes all beams of a scan at once.

    Args:
        turn: number of columns in a full turn
        columns: number of columns of a scan, half of them to the left of straight ahead
        elevations_rad: angles of the rings above the horizon
        mount_m: place on the vehicle
    """

    def __init__(
        self,
        turn: int,
        columns: int,
        elevations_rad: np.ndarray,
        mount_m: tuple[float, float, float],
        settings: SensorSettings,
        context: SensorContext,
    ):
        super().__init__(context.errors([error_sizes(settings, unit="_m")._replace(noise=0.0)]))
        self._noise_m = settings.noise_m
        self._beam_errors = context._replace(number=context.number + _BEAM_STREAM).errors([])
        self._turn, self._columns, self._step_rad = turn, columns, _TURN / turn
        self._mount_m, self._range_m = mount_m, settings.range_m
        angles = (np.arange(columns) - columns // 2) * self._step_rad
        self._first_rad = angles[0]
        self._slopes = np.tan(elevations_rad)[:, None]
        # Length of a beam for each metre on the ground.
        self._stretch = np.hypot(1.0, self._slopes)
        # Two turns: the columns of a body need no wrapping.
        turns = np.arange(2 * turn) * self._step_rad
        self._cosines, self._sines = np.cos(turns), np.sin(turns)
        with np.errstate(divide="ignore"):
            ground = np.where(self._slopes < 0.0, -mount_m[2] / self._slopes, FAR_M)
        self._ground = np.repeat(ground, 2 * turn, axis=1)
        elevations = elevations_rad[:, None]
        self._directions = np.stack(
            np.broadcast_arrays(
                np.cos(elevations) * np.cos(angles),
                np.cos(elevations) * np.sin(angles),
                np.sin(elevations),
            ),
            axis=-1,
        ).reshape(-1, 3)
        assert context.scenery is not None
        scenery = context.scenery()
        self._scenery = scenery_bodies(scenery)
        # No body of the scenery reaches farther from its origin.
        largest_m = float(np.hypot(*scenery.size_m[:, :2].T).max(initial=0.0))
        self._reach_m = settings.range_m + 0.5 * largest_m + ROOF_BEYOND_EAVES_M

    def cast(self, x_m: float, y_m: float, yaw_rad: float, bodies: Sequence[Bodies]) -> np.ndarray:
        """Return the ranges (rings, columns) from a pose in the map, infinite beyond the range [m].

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
                if len(one.position_m):
                    self._cast_bodies(nearest, x_m, y_m, yaw_rad, one)
        ranges = np.minimum(nearest[:, : self._turn], nearest[:, self._turn :])
        ranges *= self._stretch
        ranges[ranges > self._range_m] = np.inf
        return ranges[:, : self._columns]

    def _cast_bodies(
        self, nearest: np.ndarray, x_m: float, y_m: float, yaw_rad: float, bodies: Bodies
    ) -> None:
        dx, dy = bodies.position_m[:, 0] - x_m, bodies.position_m[:, 1] - y_m
        low, high = angles(bodies, dx, dy)
        first = np.ceil((low - yaw_rad) / self._step_rad).astype(np.int64)
        last = np.floor((high - yaw_rad) / self._step_rad).astype(np.int64)
        count = np.minimum(last - first + 1, self._turn)
        first %= self._turn
        # Of each beam that may hit: its body and its column.
        owner = np.repeat(np.arange(len(first)), count)
        if not len(owner):
            return
        column = np.arange(len(owner)) + (first - np.cumsum(count) + count)[owner]
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        cosine, sine = self._cosines[column], self._sines[column]
        east, north = c * cosine - s * sine, s * cosine + c * sine
        rings, height_m = self._slopes, self._mount_m[2]
        enter, leave = bodies.inside(Rays(owner, dx, dy, east, north, rings, height_m))
        if bodies.bottom_m is not None and bodies.top_m is not None:
            bottom, top = bodies.bottom_m - height_m, bodies.top_m - height_m
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

    def ranges(self, moment: Moment) -> np.ndarray:
        """Return the true ranges (rings, columns), infinite where nothing is in range [m]."""
        state, ahead = moment.state, self._mount_m[0]
        x_m = state.x_m + ahead * math.cos(state.yaw_rad)
        y_m = state.y_m + ahead * math.sin(state.yaw_rad)
        bodies = [near(one, x_m, y_m, self._reach_m) for one in self._scenery]
        if moment.obstacles or moment.traffic_lights:
            bodies += moving_bodies(moment.obstacles, moment.traffic_lights)
        return self.cast(x_m, y_m, state.yaw_rad, bodies)

    def read(self, moment: Moment, tick: int) -> np.ndarray:
        """Return the points (N, 4) of all beams that hit: x, y, z [m] and intensity, float32."""
        ranges = self.ranges(moment).ravel()
        beams = np.flatnonzero(ranges < np.inf)
        found = ranges[beams]
        # The loss is that of the true range.
        intensity = np.exp(-_LOSS_PER_M * found)
        found = found * self.errors.factors[0] + self.errors.apply([0.0], tick)[0]
        if self._noise_m:
            noise = self._beam_errors.random(tick).standard_normal(len(ranges))
            found += self._noise_m * noise[beams]
        points = np.empty((len(beams), 4), np.float32)
        np.multiply(self._directions[beams], found[:, None], out=points[:, :3], casting="unsafe")
        points[:, 3] = intensity
        return points


RINGS_RAD = np.radians(np.arange(-15.0, 16.0, 2.0))
RoofLidar = partial(LidarModel, 1024, 1024, RINGS_RAD, MOUNTS_M["lidar"])
# 270 degrees in steps of a quarter.
PlanarLidar = partial(LidarModel, 1440, 1080, np.zeros(1), MOUNTS_M["planar_lidar"])
