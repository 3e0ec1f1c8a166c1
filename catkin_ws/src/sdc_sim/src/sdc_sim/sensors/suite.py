"""All sensors of a vehicle: which of them are due in a tick, and what they measure."""

from __future__ import annotations

from collections import deque
from typing import Any, Callable, Mapping

from sdc_common.geometry.route import Route
from sdc_sim.physics.vehicle_parameters import VehicleParameters
from sdc_sim.road.scenery import Scenery
from sdc_sim.sensors.errors import DelayLine
from sdc_sim.sensors.lidar import PlanarLidar, RoofLidar
from sdc_sim.sensors.model import SENSORS, Moment, SensorContext, SensorReadings, SensorSettings
from sdc_sim.sensors.motion_sensors import Gnss, InertialUnit, Speedometer, WheelSpeedSensor

# Class and field of the readings of each sensor.
_MODELS: dict[str, tuple[Callable[[Any, SensorContext], Any], str]] = {
    "imu": (InertialUnit, "imu"),
    "gnss": (Gnss, "gnss"),
    "speedometer": (Speedometer, "speed_mps"),
    "wheel_speeds": (WheelSpeedSensor, "wheel_speeds_radps"),
    "lidar": (RoofLidar, "lidar"),
    "planar_lidar": (PlanarLidar, "planar_lidar"),
}


class SensorSuite:
    """The sensors of a vehicle.

    Args:
        settings: settings of each sensor by its name in SENSORS; one that is missing is off
        parameters: the vehicle
        tick_s: duration of a tick
        seed: of the errors
        route: the route, for zones along it
        scenery: returns trees and buildings, for the lidars

    Raises:
        ValueError: a zone is not on the route
    """

    def __init__(
        self,
        settings: Mapping[str, SensorSettings],
        parameters: VehicleParameters,
        tick_s: float,
        seed: int = 0,
        route: Route | None = None,
        scenery: Callable[[], Scenery] | None = None,
    ):
        # Field of the readings, period and latency in ticks, and model of each sensor that is on.
        self._sensors: list[tuple[str, int, int, Any]] = []
        for number, name in enumerate(SENSORS):
            if name not in settings:
                continue
            sensor = settings[name]
            period_ticks = max(1, DelayLine(sensor.period_s, tick_s).ticks)
            latency_ticks = DelayLine(sensor.latency_s, tick_s).ticks
            model_class, field = _MODELS[name]
            context = SensorContext(seed, number, period_ticks * tick_s, parameters, route, scenery)
            self._sensors.append((field, period_ticks, latency_ticks, model_class(sensor, context)))
        longest_latency = max((latency for _, _, latency, _ in self._sensors), default=0)
        self._moments: deque[Moment] = deque(maxlen=1 + longest_latency)

    def reset(self) -> None:
        """Return to the start of the drive."""
        self._moments.clear()
        for *_, model in self._sensors:
            model.reset()

    def sense(self, moment: Moment, tick: int, number: int) -> SensorReadings:
        """Return the readings of a tick, which decides which sensors are due.

        `number` is that of the tick since the start.
        """
        self._moments.append(moment)
        last = len(self._moments) - 1
        # Before the start the vehicle was where it starts.
        return SensorReadings(
            **{
                field: model.read(self._moments[max(0, last - latency_ticks)], number)
                for field, period_ticks, latency_ticks, model in self._sensors
                if tick % period_ticks == 0
            }
        )
