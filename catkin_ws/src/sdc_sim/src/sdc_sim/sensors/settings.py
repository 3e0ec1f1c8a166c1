"""Settings of the sensors, as config/sim.yaml and the scenarios contain them.

Each error is a standard deviation. A sensor with a period of 0 is off.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

from sdc_sim.yaml_document import check_parameter, schema

# Names of the sensors in the settings, in the order in which they are published.
SENSORS = ("imu", "gnss", "speedometer", "lidar", "planar_lidar", "wheel_speeds")


@dataclass(frozen=True)
class Zone:
    """A part of the drive: a stretch of the route, or a time since the start.

    Attributes:
        from_m: start of the stretch along the route
        to_m: end of the stretch
        from_s: start of the time
        to_s: end of the time
        offset_m: standard deviation of the position's offset, in a multipath zone
    """

    from_m: float | None = None
    to_m: float | None = None
    from_s: float | None = None
    to_s: float | None = None
    offset_m: float = 0.0

    def __post_init__(self) -> None:
        along, times = (self.from_m, self.to_m), (self.from_s, self.to_s)
        start, end = times if self.from_m is None else along
        if start is None or end is None or not start < end:
            raise ValueError(f"a zone of gnss must end after its start, got {start} to {end}")


@dataclass(frozen=True)
class SensorSettings:
    """What all sensors have.

    Attributes:
        period_s: time between two readings, in whole ticks; 0: the sensor is off
        latency_s: age of a reading in the tick in which it is published, in whole ticks
    """

    period_s: float = 0.0
    latency_s: float = 0.0


@dataclass(frozen=True)
class ImuSettings(SensorSettings):
    """Errors of accelerometer and gyroscope."""

    acceleration_noise_mps2: float = 0.0
    acceleration_bias_mps2: float = 0.0
    acceleration_walk_mps2: float = 0.0
    acceleration_scale: float = 0.0
    rate_noise_radps: float = 0.0
    rate_bias_radps: float = 0.0
    rate_walk_radps: float = 0.0
    rate_scale: float = 0.0


@dataclass(frozen=True)
class GnssSettings(SensorSettings):
    """Errors of the position on each axis, zones without a fix, and zones with reflections."""

    noise_m: float = 0.0
    bias_m: float = 0.0
    walk_m: float = 0.0
    outages: tuple[Zone, ...] = ()
    multipath: tuple[Zone, ...] = ()


@dataclass(frozen=True)
class SpeedometerSettings(SensorSettings):
    """Errors of the speed."""

    noise_mps: float = 0.0
    bias_mps: float = 0.0
    walk_mps: float = 0.0
    scale: float = 0.0


@dataclass(frozen=True)
class WheelSpeedSettings(SensorSettings):
    """Errors of the angular velocity of each wheel; the scale is that of its radius."""

    noise_radps: float = 0.0
    bias_radps: float = 0.0
    walk_radps: float = 0.0
    scale: float = 0.0


@dataclass(frozen=True)
class LidarSettings(SensorSettings):
    """Errors of the ranges, and the largest range."""

    noise_m: float = 0.0
    bias_m: float = 0.0
    walk_m: float = 0.0
    scale: float = 0.0
    range_m: float = 80.0


CLASSES = {
    "imu": ImuSettings,
    "gnss": GnssSettings,
    "speedometer": SpeedometerSettings,
    "lidar": LidarSettings,
    "planar_lidar": LidarSettings,
    "wheel_speeds": WheelSpeedSettings,
}


def sensor_settings(name: str, values: Mapping[str, Any]) -> Any:
    """Return the settings of a sensor.

    Args:
        name: one of SENSORS
        values: its settings by name; one that is missing has its default

    Raises:
        ValueError: a setting is unknown or out of range; the message names it
    """
    check_parameter(name, values, schema("scenario")["properties"][name])
    read = {
        key: tuple(Zone(**zone) for zone in value) if key in ("outages", "multipath") else value
        for key, value in values.items()
    }
    return CLASSES[name](**read)
