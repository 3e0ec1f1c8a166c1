"""The true state of a simulation at one tick, and what the car receives of it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sdc_common.driving import DetectedObstacle, Observation, yaw_as_sent
from sdc_sim.physics.obstacles import CollisionEvent, ObstacleState
from sdc_sim.physics.traffic_lights import TrafficLightState
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.sensors.model import SensorReadings

_NS_PER_S = 1_000_000_000


class Snapshot(NamedTuple):
    """What is true at one tick, at most sensor_latency_s late, and what the sensors measure."""

    stamp_ns: int  # simulated time [ns]
    state: VehicleState  # true state of the vehicle
    measured: VehicleState  # state of the vehicle with the noise of its odometry
    obstacles: tuple[ObstacleState, ...] = ()  # all obstacles
    traffic_lights: tuple[TrafficLightState, ...] = ()  # all traffic lights
    # Contacts that began in the last tick; they have no latency.
    collisions: tuple[CollisionEvent, ...] = ()
    readings: SensorReadings = SensorReadings()  # what the sensors measure in this tick
    z_m: float = 0.0  # height of the ground below the vehicle
    pitch_rad: float = 0.0  # pitch of the vehicle, positive with the nose down

    @property
    def time_s(self) -> float:
        """Simulated time [s]."""
        seconds, nanoseconds = divmod(self.stamp_ns, _NS_PER_S)
        return seconds + nanoseconds / 1e9

    def observation(self) -> Observation:
        """Return what the software of the car receives of it, rounded as in the messages."""
        measured = self.measured
        return Observation(
            self.stamp_ns,
            measured.x_m,
            measured.y_m,
            yaw_as_sent(measured.yaw_rad, self.pitch_rad),
            math.hypot(measured.speed_mps, measured.lateral_speed_mps),
            tuple(map(detected, self.obstacles)),
            {light.id: light.state for light in self.traffic_lights},
            self.readings,
            self.z_m,
        )


def detected(state: ObstacleState) -> DetectedObstacle:
    """Return what the software of the car receives of an obstacle, rounded as in the messages."""
    yaw, speed = yaw_as_sent(state.yaw_rad, state.pitch_rad), float(np.float32(state.speed_mps))
    box = state.x_m, state.y_m, yaw, state.length_m, state.width_m
    return DetectedObstacle(*box, speed, state.id, state.kind, state.z_m)
