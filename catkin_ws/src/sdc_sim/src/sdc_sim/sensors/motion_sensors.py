"""Sensors of the vehicle's own motion: inertial unit, speedometer, wheel speeds, GNSS."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, Callable, Mapping, Sequence

from sdc_common.geometry.polyline import Polyline
from sdc_common.geometry.route import Route
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.physics.vehicle_dynamics import GRAVITY_MPS2
from sdc_sim.physics.vehicle_parameters import VehicleParameters
from sdc_sim.sensors.errors import ErrorSizes
from sdc_sim.sensors.model import (
    MOUNTS_M,
    GnssReading,
    ImuReading,
    Moment,
    SensorContext,
    SensorModel,
    SensorSettings,
    error_sizes,
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


class DirectSensor(SensorModel):
    """A sensor that measures what the state of the vehicle holds.

    Args:
        true: returns the true numbers of a state and a vehicle
        reading: makes a reading of the measured numbers
        errors: prefix and unit of the settings of each number's errors, see error_sizes
    """

    def __init__(
        self,
        true: Callable[[VehicleState, VehicleParameters], Sequence[float]],
        reading: Callable[[list[float]], Any],
        errors: Sequence[tuple[str, str]],
        settings: SensorSettings,
        context: SensorContext,
    ):
        super().__init__(context.errors([error_sizes(settings, *error) for error in errors]))
        self._true, self._reading, self._parameters = true, reading, context.parameters

    def read(self, moment: Moment, tick: int) -> Any:
        """Return the reading."""
        return self._reading(self.errors.apply(self._true(moment.state, self._parameters), tick))


def _inertia(state: VehicleState, _parameters: VehicleParameters) -> Sequence[float]:
    """Return specific force and angular velocity.

    At rest, the specific force is that of the ground against gravity.
    """
    ahead, left = state.longitudinal_acceleration_mps2, state.lateral_acceleration_mps2
    return ahead, left, GRAVITY_MPS2, 0.0, 0.0, state.yaw_rate_radps


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


# Accelerometer and gyroscope at the centre of gravity.
InertialUnit = partial(
    DirectSensor,
    _inertia,
    lambda measured: ImuReading(measured[:3], measured[3:]),
    [("acceleration_", "_mps2")] * 3 + [("rate_", "_radps")] * 3,
)
# Speed in the direction of the vehicle.
Speedometer = partial(
    DirectSensor, lambda state, _: [state.speed_mps], lambda measured: measured[0], [("", "_mps")]
)
# Angular velocities of the four wheels, in the order of WHEELS.
WheelSpeedSensor = partial(DirectSensor, wheel_speeds_radps, list, [("", "_radps")] * 4)


class _Zone:
    """A part of the drive: a stretch of the route, or a time since the start.

    Args:
        route: the route
        zone: from_m and to_m along the route, or from_s and to_s, and offset_m, the standard
            deviation of the position's offset in a multipath zone

    Raises:
        ValueError: the zone is not on the route, or ends before its start
    """

    def __init__(self, route: Route | None, zone: Mapping[str, float]):
        self.offset_m = zone.get("offset_m", 0.0)
        unit = "m" if "from_m" in zone else "s"
        self._start, self._end = start, end = zone["from_" + unit], zone["to_" + unit]
        self._line: Polyline | None = None
        if not start < end:
            raise ValueError(f"a zone of gnss must end after its start, got {start} to {end}")
        if unit == "s":
            return
        assert route is not None
        if end > route.length_m:
            raise ValueError(
                f"a zone ends {end:g} m along a route of {route.length_m:.1f} m; "
                f"give a distance up to {route.length_m:.1f}"
            )
        inside = route.points[(route.s > start) & (route.s < end)].tolist()
        self._line = Polyline([route.line.point_at(start), *inside, route.line.point_at(end)])

    def contains(self, moment: Moment) -> bool:
        """Return whether the vehicle is in the zone."""
        if self._line is None:
            return self._start <= moment.elapsed_s < self._end
        place = self._line.nearest(moment.state.x_m, moment.state.y_m)
        return place.distance_m < _ZONE_HALF_WIDTH_M and 0.0 <= place.s_m < self._line.s[-1]


class Gnss(SensorModel):
    """A receiver above the centre of the vehicle.

    Raises:
        ValueError: a zone is not on the route
    """

    def __init__(self, settings: SensorSettings, context: SensorContext):
        super().__init__(context.errors([error_sizes(settings, unit="_m")] * 3))
        reflections = context._replace(number=context.number + _SECOND_STREAM)
        self._reflections = reflections.errors([ErrorSizes(1.0)] * 2)
        self._outages = [_Zone(context.route, zone) for zone in settings.outages]
        self._multipath = [_Zone(context.route, zone) for zone in settings.multipath]
        self._keep = math.exp(-context.period_s / _MULTIPATH_TIME_S)
        self._offset_m: list[float] | None = None

    def read(self, moment: Moment, tick: int) -> GnssReading:
        """Return the position of the antenna."""
        state = moment.state
        z_m = moment.z_m + MOUNTS_M["gnss"][2]
        position = self.errors.apply((state.x_m, state.y_m, z_m), tick)
        offset = self._multipath_offset(moment, tick)
        if any(zone.contains(moment) for zone in self._outages):
            return GnssReading(0.0, 0.0, 0.0, False)
        return GnssReading(position[0] + offset[0], position[1] + offset[1], position[2], True)

    def _multipath_offset(self, moment: Moment, tick: int) -> Sequence[float]:
        """Return the offset of the position by reflections, a first-order Gauss-Markov process."""
        sizes = [region.offset_m for region in self._multipath if region.contains(moment)]
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
