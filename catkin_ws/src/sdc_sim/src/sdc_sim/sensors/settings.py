"""Settings of the sensors, as config/sim.yaml and the scenarios contain them.

Each error is a standard deviation. A sensor with a period of 0 is off.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Mapping, Sequence

from sdc_common.suggestion import suggestion
from sdc_common.validation import check_between, check_non_negative

_MAX_PERIOD_S = 1e3
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
        used, other = (along, times) if times == (None, None) else (times, along)
        if None in used or other != (None, None):
            raise ValueError("must have from_m and to_m, or from_s and to_s")
        check_non_negative(start=used[0], end=used[1], offset_m=self.offset_m)
        if not used[0] < used[1]:  # type: ignore[operator]
            raise ValueError(f"must end after its start, got {used[0]} to {used[1]}")


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
    settings_class = CLASSES[name]
    if not isinstance(values, Mapping):
        raise ValueError(f"{name} must be a mapping such as {{period_s: 0.1}}, got {values!r}")
    known = [field.name for field in dataclasses.fields(settings_class)]
    for key in values:
        if key not in known:
            hint = suggestion(str(key), known, f"it has {', '.join(known)}")
            raise ValueError(f"{name} has no '{key}'; {hint}")
    read = {
        key: _zones(f"{name}.{key}", value) if key in ("outages", "multipath") else value
        for key, value in values.items()
    }
    for key, value in read.items():
        if not isinstance(value, tuple):
            check_between(0.0, _MAX_PERIOD_S, **{f"{name}.{key}": value})
    return settings_class(**read)


def _zones(name: str, values: Any) -> tuple[Zone, ...]:
    if not isinstance(values, Sequence) or isinstance(values, str):
        raise ValueError(f"{name} must be a list such as [{{from_m: 100, to_m: 200}}]")
    zones = []
    for number, value in enumerate(values, start=1):
        try:
            zones.append(Zone(**value))
        except (TypeError, ValueError) as error:
            raise ValueError(f"{name}, zone {number}: {error}") from None
    return tuple(zones)
