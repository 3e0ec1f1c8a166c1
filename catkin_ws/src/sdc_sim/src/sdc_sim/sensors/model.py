"""What the models of all sensors have in common."""

from __future__ import annotations

from typing import Any, Callable, NamedTuple, Sequence

from sdc_common.geometry.route import Route
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import TrafficLightState
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.physics.vehicle_parameters import VehicleParameters
from sdc_sim.road.scenery import Scenery
from sdc_sim.sensors.errors import ErrorSizes, SensorErrors


class Moment(NamedTuple):
    """What there is to measure in a tick.

    Attributes:
        elapsed_s: time since the start
        state: true state of the vehicle
        obstacles: all obstacles
        traffic_lights: all traffic lights
    """

    elapsed_s: float
    state: VehicleState
    obstacles: Sequence[ObstacleState] = ()
    traffic_lights: Sequence[TrafficLightState] = ()


class SensorContext(NamedTuple):
    """What the model of a sensor is built with.

    Attributes:
        seed: seed of the drive
        number: number of the sensor
        period_s: time between two readings
        parameters: the vehicle
        route: the route, for zones along it
        scenery: returns trees and buildings, for the lidars
    """

    seed: int
    number: int
    period_s: float
    parameters: VehicleParameters
    route: Route | None
    scenery: Callable[[], Scenery] | None = None

    def errors(self, sizes: Sequence[ErrorSizes]) -> SensorErrors:
        """Return errors of these sizes, one for each quantity."""
        return SensorErrors(self.seed, self.number, sizes, self.period_s)


class SensorModel:
    """A sensor whose state is that of its errors."""

    def __init__(self, errors: SensorErrors):
        self.errors = errors

    def read(self, moment: Moment, tick: int) -> Any:
        """Return a reading.

        Args:
            moment: what is measured
            tick: number of the tick since the start
        """
        raise NotImplementedError

    def reset(self) -> None:
        """Return to the start of the drive."""
        self.errors.reset()
