"""Settings of the sensors; config/sim.yaml describes each of them and has its default.

Each error is a standard deviation. A sensor with a period of 0 is off.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, Mapping

from sdc_sim.yaml_document import check_parameter, packaged_config, schema

# Names of the sensors in the settings, in the order in which they are published.
SENSORS = ("imu", "gnss", "speedometer", "lidar", "planar_lidar", "wheel_speeds")
# The settings of a sensor as attributes, `period_s` for instance.
SensorSettings = SimpleNamespace


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


def sensor_settings(name: str, values: Mapping[str, Any]) -> SensorSettings:
    """Return the settings of a sensor.

    Args:
        name: one of SENSORS
        values: its settings by name; one that is missing has its default

    Raises:
        ValueError: a setting is unknown or out of range; the message names it
    """
    check_parameter(name, values, schema("scenario")["properties"][name])
    every = {**packaged_config("sim")[name], **values}
    for key in {"outages", "multipath"} & set(every):
        every[key] = tuple(Zone(**zone) for zone in every[key])
    return SensorSettings(**every)
