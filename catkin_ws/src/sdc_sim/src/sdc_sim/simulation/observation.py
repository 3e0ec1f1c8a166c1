"""What the sensors of a simulation show at one tick."""

from __future__ import annotations

from typing import Any, NamedTuple

from sdc_sim.physics.obstacles import CollisionEvent, ObstacleState
from sdc_sim.physics.traffic_lights import TrafficLightState
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.sensors.readings import SensorReadings
from sdc_sim.simulation.answer_tracker import Stamp


class Observation(NamedTuple):
    """What the sensors show at one tick, at most sensor_latency_s late.

    Attributes:
        stamp: simulated time (seconds, nanoseconds)
        state: true state of the vehicle
        measured: state of the vehicle with the noise of its odometry
        obstacles: all obstacles
        traffic_lights: all traffic lights
        collisions: contacts that began in the last tick; they have no latency
        readings: what the sensors measure in this tick
    """

    stamp: Stamp
    state: VehicleState
    measured: VehicleState
    obstacles: tuple[ObstacleState, ...] = ()
    traffic_lights: tuple[TrafficLightState, ...] = ()
    collisions: tuple[CollisionEvent, ...] = ()
    readings: SensorReadings = SensorReadings()

    @property
    def time_s(self) -> float:
        """Simulated time [s]."""
        seconds, nanoseconds = self.stamp
        return seconds + nanoseconds / 1e9

    def plain(self) -> list[Any]:
        """Return the observation as plain data, without the readings."""
        return [
            self.stamp,
            list(vars(self.state).values()),
            None if self.measured is self.state else list(vars(self.measured).values()),
            [tuple(obstacle) for obstacle in self.obstacles],
            [tuple(light) for light in self.traffic_lights],
            [tuple(event) for event in self.collisions],
        ]

    @staticmethod
    def from_plain(plain: list[Any]) -> Observation:
        """Return the observation in plain data."""
        stamp, state, measured, obstacles, lights, collisions = plain
        state = VehicleState(*state)
        return Observation(
            (stamp[0], stamp[1]),
            state,
            state if measured is None else VehicleState(*measured),
            tuple(ObstacleState(*obstacle) for obstacle in obstacles),
            tuple(TrafficLightState(*light) for light in lights),
            tuple(CollisionEvent(*event) for event in collisions),
        )
