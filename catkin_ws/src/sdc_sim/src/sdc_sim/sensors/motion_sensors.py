"""Sensors of the vehicle's own motion: inertial unit, speedometer, wheel speeds, GNSS."""

from __future__ import annotations

import math
from typing import Sequence

from sdc_common.geometry.polyline import Polyline
from sdc_common.geometry.route import Route
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.physics.vehicle_dynamics import GRAVITY_MPS2
from sdc_sim.physics.vehicle_parameters import VehicleParameters
from sdc_sim.sensors.errors import ErrorSizes
from sdc_sim.sensors.model import (
    GNSS_MOUNT_M,
    GnssReading,
    ImuReading,
    Moment,
    SensorContext,
    SensorModel,
    SensorSettings,
    Zone,
)

# The vehicle model has no wheels; these values are nominal.
WHEEL_RADIUS_M = 0.35
TRACK_SHARE = 0.8
# A tunnel is this wide on each side of the route: the whole road.
_ZONE_HALF_WIDTH_M = 10.0
# Reflections change while the vehicle moves past buildings.
_MULTIPATH_TIME_S = 5.0
# Added to the number of the sensor for random numbers of their own.
_SECOND_STREAM = 128


class InertialUnit(SensorModel):
    """Accelerometer and gyroscope at the centre of gravity."""

    def __init__(self, settings: SensorSettings, context: SensorContext):
        acceleration = ErrorSizes(
            settings.acceleration_noise_mps2,
            settings.acceleration_bias_mps2,
            settings.acceleration_walk_mps2,
            settings.acceleration_scale,
        )
        rate = ErrorSizes(
            settings.rate_noise_radps,
            settings.rate_bias_radps,
            settings.rate_walk_radps,
            settings.rate_scale,
        )
        super().__init__(context.errors([acceleration] * 3 + [rate] * 3))

    def read(self, moment: Moment, tick: int) -> ImuReading:
        """Return the specific force, which at rest is that of the ground against gravity."""
        state = moment.state
        ahead, left = state.longitudinal_acceleration_mps2, state.lateral_acceleration_mps2
        true = (ahead, left, GRAVITY_MPS2, 0.0, 0.0, state.yaw_rate_radps)
        measured = self.errors.apply(true, tick)
        return ImuReading(measured[:3], measured[3:])


class Speedometer(SensorModel):
    """Speed in the direction of the vehicle."""

    def __init__(self, settings: SensorSettings, context: SensorContext):
        one = settings
        super().__init__(
            context.errors([ErrorSizes(one.noise_mps, one.bias_mps, one.walk_mps, one.scale)])
        )

    def read(self, moment: Moment, tick: int) -> float:
        """Return the speed [m/s]."""
        return self.errors.apply([moment.state.speed_mps], tick)[0]


class WheelSpeedSensor(SensorModel):
    """Angular velocities of the four wheels."""

    def __init__(self, settings: SensorSettings, context: SensorContext):
        one = settings
        sizes = ErrorSizes(one.noise_radps, one.bias_radps, one.walk_radps, one.scale)
        super().__init__(context.errors([sizes] * 4))
        self._parameters = context.parameters

    def read(self, moment: Moment, tick: int) -> list[float]:
        """Return the angular velocities in the order of WHEELS [rad/s]."""
        return self.errors.apply(wheel_speeds_radps(moment.state, self._parameters), tick)


def wheel_speeds_radps(state: VehicleState, parameters: VehicleParameters) -> list[float]:
    """Return the angular velocities of wheels that roll without slip, in the order of WHEELS.

    A wheel turns with the velocity of its centre along its own plane.
    """
    u, r = state.speed_mps, state.yaw_rate_radps
    half_track_m = 0.5 * TRACK_SHARE * parameters.width_m
    c, s = math.cos(state.wheel_angle_rad), math.sin(state.wheel_angle_rad)
    aside = state.lateral_speed_mps + parameters.front_axle_m * r
    left, right = u - half_track_m * r, u + half_track_m * r
    along = (c * left + s * aside, c * right + s * aside, left, right)
    return [speed / WHEEL_RADIUS_M for speed in along]


class _ZoneOnRoute:
    """Decides whether the vehicle is in a zone.

    Raises:
        ValueError: the zone is not on the route
    """

    def __init__(self, zone: Zone, route: Route | None):
        self.zone = zone
        self._line: Polyline | None = None
        if zone.from_m is None or zone.to_m is None:
            return
        if route is None:
            raise ValueError("a zone in metres needs a route; give from_s and to_s")
        if zone.to_m > route.length_m:
            raise ValueError(
                f"a zone ends {zone.to_m:g} m along a route of {route.length_m:.1f} m; "
                f"give a distance up to {route.length_m:.1f}"
            )
        inside = route.points[(route.s > zone.from_m) & (route.s < zone.to_m)].tolist()
        ends = route.line.point_at(zone.from_m), route.line.point_at(zone.to_m)
        self._line = Polyline([ends[0], *inside, ends[1]])

    def contains(self, moment: Moment) -> bool:
        """Return whether the vehicle is in the zone."""
        if self._line is None:
            return self.zone.from_s <= moment.elapsed_s < self.zone.to_s  # type: ignore[operator]
        place = self._line.nearest(moment.state.x_m, moment.state.y_m)
        return place.distance_m < _ZONE_HALF_WIDTH_M and 0.0 <= place.s_m < self._line.s[-1]


class Gnss(SensorModel):
    """A receiver above the centre of the vehicle.

    Raises:
        ValueError: a zone is not on the route
    """

    def __init__(self, settings: SensorSettings, context: SensorContext):
        sizes = ErrorSizes(settings.noise_m, settings.bias_m, settings.walk_m)
        super().__init__(context.errors([sizes] * 3))
        reflections = context._replace(number=context.number + _SECOND_STREAM)
        self._reflections = reflections.errors([ErrorSizes(1.0)] * 2)
        self._outages = [_ZoneOnRoute(zone, context.route) for zone in settings.outages]
        self._multipath = [_ZoneOnRoute(zone, context.route) for zone in settings.multipath]
        self._keep = math.exp(-context.period_s / _MULTIPATH_TIME_S)
        self._offset_m: list[float] | None = None

    def read(self, moment: Moment, tick: int) -> GnssReading:
        """Return the position of the antenna."""
        state = moment.state
        position = self.errors.apply((state.x_m, state.y_m, GNSS_MOUNT_M[2]), tick)
        offset = self._multipath_offset(moment, tick)
        if any(zone.contains(moment) for zone in self._outages):
            return GnssReading(0.0, 0.0, 0.0, False)
        return GnssReading(position[0] + offset[0], position[1] + offset[1], position[2], True)

    def _multipath_offset(self, moment: Moment, tick: int) -> Sequence[float]:
        """Return the offset of the position by reflections, a first-order Gauss-Markov process."""
        sizes = [one.zone.offset_m for one in self._multipath if one.contains(moment)]
        size = max(sizes, default=0.0)
        if size == 0.0:
            self._offset_m = None
            return (0.0, 0.0)
        draws = self._reflections.apply((0.0, 0.0), tick)
        if self._offset_m is None:
            self._offset_m = [size * draw for draw in draws]
        else:
            grow = size * math.sqrt(1.0 - self._keep**2)
            self._offset_m = [
                self._keep * offset + grow * draw for offset, draw in zip(self._offset_m, draws)
            ]
        return self._offset_m

    def reset(self) -> None:
        """Return to the start of the drive."""
        super().reset()
        self._offset_m = None
