"""Lidars of the vehicle: one with 16 rings on the roof, and a planar one at the front."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sdc_sim.sensors.errors import ErrorSizes
from sdc_sim.sensors.model import Moment, SensorContext, SensorModel
from sdc_sim.sensors.mounts import LIDAR_MOUNT_M, PLANAR_LIDAR_MOUNT_M
from sdc_sim.sensors.ray_casting import RayCaster
from sdc_sim.sensors.settings import LidarSettings
from sdc_sim.sensors.solid_world import NearBodies, moving_bodies

# Share of the light that is lost for each metre, as CARLA's default.
_LOSS_PER_M = 0.004
# Added to the number of the sensor for the noise of the beams.
_BEAM_STREAM = 128


class Beams(NamedTuple):
    """Directions of the beams of a lidar.

    Attributes:
        turn: number of columns in a full turn
        first: first column, counted from straight ahead to the left
        columns: number of columns
        elevations_rad: angles of the rings above the horizon
        mount_m: place on the vehicle
    """

    turn: int
    first: int
    columns: int
    elevations_rad: np.ndarray
    mount_m: tuple[float, float, float]


RINGS = Beams(1024, -512, 1024, np.radians(np.arange(-15.0, 16.0, 2.0)), LIDAR_MOUNT_M)
# 270 degrees in steps of a quarter.
PLANAR = Beams(1440, -540, 1080, np.zeros(1), PLANAR_LIDAR_MOUNT_M)


class LidarModel(SensorModel):
    """A lidar that takes all beams of a scan at once."""

    def __init__(self, beams: Beams, settings: LidarSettings, context: SensorContext):
        one = settings
        super().__init__(context.errors([ErrorSizes(0.0, one.bias_m, one.walk_m, one.scale)]))
        self._noise_m = one.noise_m
        self._beam_errors = context._replace(number=context.number + _BEAM_STREAM).errors([])
        self._mount_m = beams.mount_m
        angles = np.arange(beams.first, beams.first + beams.columns) * (2.0 * np.pi / beams.turn)
        self._caster = RayCaster(
            beams.turn, angles[0], beams.elevations_rad, beams.mount_m[2], settings.range_m
        )
        self._columns = beams.columns
        elevations = beams.elevations_rad[:, None]
        self._directions = np.stack(
            np.broadcast_arrays(
                np.cos(elevations) * np.cos(angles),
                np.cos(elevations) * np.sin(angles),
                np.sin(elevations),
            ),
            axis=-1,
        ).reshape(-1, 3)
        if context.scenery is None:
            raise ValueError("a lidar needs a road with its scenery")
        level = len(elevations) == 1
        self._scenery = NearBodies(
            context.scenery(), settings.range_m, beams.mount_m[2] if level else None
        )

    def ranges(self, moment: Moment) -> np.ndarray:
        """Return the true ranges (rings, columns), infinite where nothing is in range [m]."""
        state, ahead = moment.state, self._mount_m[0]
        x_m = state.x_m + ahead * math.cos(state.yaw_rad)
        y_m = state.y_m + ahead * math.sin(state.yaw_rad)
        bodies = self._scenery.around(x_m, y_m)
        if moment.obstacles or moment.traffic_lights:
            bodies = [*bodies, *moving_bodies(moment.obstacles, moment.traffic_lights)]
        ranges = self._caster.cast(x_m, y_m, state.yaw_rad, bodies)
        return ranges[:, : self._columns]

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


class RoofLidar(LidarModel):
    """The lidar with 16 rings."""

    def __init__(self, settings: LidarSettings, context: SensorContext):
        super().__init__(RINGS, settings, context)


class PlanarLidar(LidarModel):
    """The planar lidar."""

    def __init__(self, settings: LidarSettings, context: SensorContext):
        super().__init__(PLANAR, settings, context)
