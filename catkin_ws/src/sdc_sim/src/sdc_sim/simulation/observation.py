"""What the sensors of a simulation show at one tick."""

from __future__ import annotations

from typing import NamedTuple

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
