"""What all sensors have in common: settings, what they measure, readings, places.

config/sim.yaml describes each setting and has its default. Each error is a standard deviation. A
sensor with a period of 0 is off.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, Callable, Mapping, NamedTuple, Sequence

import numpy as np

from sdc_common.geometry.route import Route
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import TrafficLightState
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.physics.vehicle_parameters import VehicleParameters
from sdc_sim.road.scenery import Scenery
from sdc_sim.sensors.errors import ErrorSizes, SensorErrors
from sdc_sim.yaml_document import packaged_config

# Names of the sensors in the settings, in the order in which they are published.
SENSORS = ("imu", "gnss", "speedometer", "lidar", "planar_lidar", "wheel_speeds")
# The settings of a sensor as attributes, `period_s` for instance.
SensorSettings = SimpleNamespace
# Places on the vehicle of the sensors that have a frame.
MOUNTS_M = {
    "imu": (0.0, 0.0, 0.5),
    "gnss": (0.0, 0.0, 1.5),
    "lidar": (0.0, 0.0, 2.4),
    "planar_lidar": (2.35, 0.0, 0.6),
}
# The beams of the planar lidar: 270 degrees in steps of a quarter.
PLANAR_BEAMS = 1080
PLANAR_STEP_RAD = 2.0 * np.pi / 1440
WHEELS = ("front_left", "front_right", "rear_left", "rear_right")


class ImuReading(NamedTuple):
    """Specific force and angular velocity in the frame of the vehicle (x forward, y left, z up)."""

    acceleration_mps2: Sequence[float]
    rate_radps: Sequence[float]


class GnssReading(NamedTuple):
    """A position in the map; all numbers are zero without a fix."""

    x_m: float
    y_m: float
    z_m: float
    has_fix: bool


class SensorReadings(NamedTuple):
    """Readings of one tick, None for a sensor that is off or not due."""

    imu: ImuReading | None = None  # acceleration and rotation
    gnss: GnssReading | None = None  # position
    speed_mps: float | None = None  # speedometer, the speed in the direction of the vehicle
    wheel_speeds_radps: Sequence[float] | None = None  # angular velocities in the order of WHEELS
    # Points of the lidar with 16 rings (N, 4): x, y, z [m] in its frame, intensity 0..1.
    lidar: np.ndarray | None = None
    planar_lidar: np.ndarray | None = None  # points of the planar lidar, in the same form


class Moment(NamedTuple):
    """What there is to measure in a tick."""

    elapsed_s: float  # time since the start
    state: VehicleState  # true state of the vehicle
    obstacles: Sequence[ObstacleState] = ()  # all obstacles
    traffic_lights: Sequence[TrafficLightState] = ()  # all traffic lights
    z_m: float = 0.0  # height of the ground below the vehicle
    pitch_rad: float = 0.0  # pitch of the vehicle, positive with the nose down

    def plane_at(self, x_m: float, y_m: float) -> float:
        """Return the height of the plane on which the vehicle is at a place [m]."""
        c, s = math.cos(self.state.yaw_rad), math.sin(self.state.yaw_rad)
        ahead_m = c * (x_m - self.state.x_m) + s * (y_m - self.state.y_m)
        return self.z_m - math.tan(self.pitch_rad) * ahead_m


class SensorContext(NamedTuple):
    """What the model of a sensor is built with."""

    seed: int  # seed of the drive
    number: int  # number of the sensor
    period_s: float  # time between two readings
    parameters: VehicleParameters  # the vehicle
    route: Route | None  # the route, for zones along it
    scenery: Callable[[], Scenery] | None = None  # returns trees and buildings, for the lidars

    def errors(self, sizes: Sequence[ErrorSizes]) -> SensorErrors:
        """Return errors of these sizes, one for each quantity."""
        return SensorErrors(self.seed, self.number, sizes, self.period_s)


class SensorModel:
    """A sensor whose state is that of its errors.

    A subclass has `read(moment, tick)`, which returns a reading in the tick of this number since
    the start.
    """

    def __init__(self, errors: SensorErrors):
        self.errors = errors

    def reset(self) -> None:
        """Return to the start of the drive."""
        self.errors.reset()


def error_sizes(settings: SensorSettings, prefix: str = "", unit: str = "") -> ErrorSizes:
    """Return the error sizes of a quantity from settings such as `rate_noise_radps`.

    Args:
        settings: settings of the sensor
        prefix: in front of noise, bias, walk and scale in their names
        unit: after noise, bias and walk
    """
    values = vars(settings)
    noise, bias, walk = (values[prefix + kind + unit] for kind in ("noise", "bias", "walk"))
    # A position has no scale.
    return ErrorSizes(noise, bias, walk, values.get(prefix + "scale", 0.0))


def sensor_settings(name: str, values: Mapping[str, Any]) -> SensorSettings:
    """Return the settings of one of SENSORS; one that is not among the values has its default."""
    return SensorSettings(**{**packaged_config("sim")[name], **values})
