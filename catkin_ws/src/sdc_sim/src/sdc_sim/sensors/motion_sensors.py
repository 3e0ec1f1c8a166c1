"""Sensors of the vehicle's own motion: inertial unit, speedometer, wheel speeds."""

from __future__ import annotations

import math

from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.physics.vehicle_dynamics import GRAVITY_MPS2
from sdc_sim.physics.vehicle_parameters import VehicleParameters
from sdc_sim.sensors.errors import ErrorSizes
from sdc_sim.sensors.model import Moment, SensorContext, SensorModel
from sdc_sim.sensors.readings import ImuReading
from sdc_sim.sensors.settings import ImuSettings, SpeedometerSettings, WheelSpeedSettings

# The vehicle model has no wheels; these values are nominal.
WHEEL_RADIUS_M = 0.35
TRACK_SHARE = 0.8


class InertialUnit(SensorModel):
    """Accelerometer and gyroscope at the centre of gravity."""

    def __init__(self, settings: ImuSettings, context: SensorContext):
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

    def __init__(self, settings: SpeedometerSettings, context: SensorContext):
        one = settings
        super().__init__(
            context.errors([ErrorSizes(one.noise_mps, one.bias_mps, one.walk_mps, one.scale)])
        )

    def read(self, moment: Moment, tick: int) -> float:
        """Return the speed [m/s]."""
        return self.errors.apply([moment.state.speed_mps], tick)[0]


class WheelSpeedSensor(SensorModel):
    """Angular velocities of the four wheels."""

    def __init__(self, settings: WheelSpeedSettings, context: SensorContext):
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
