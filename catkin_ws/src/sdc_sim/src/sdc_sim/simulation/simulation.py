"""The world at one tick: the car, who drives it, what it meets, what it senses, and simulated time."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from sdc_common.validation import check_between
from sdc_sim.physics.ackermann import AckermannControl, AckermannTarget
from sdc_sim.physics.collision import Rectangle
from sdc_sim.physics.obstacles import CollisionEvent, ObstaclePlan, Obstacles, ObstacleState
from sdc_sim.physics.traffic_lights import TrafficLights, TrafficLightState
from sdc_sim.physics.vehicle import Vehicle, VehicleCommand, VehicleState
from sdc_sim.simulation.command_mux import CommandMux
from sdc_sim.simulation.sensors import DelayLine, OdometryNoise

_NANOSECONDS = 1_000_000_000


class OccupiedError(ValueError):
    """An obstacle stands where the car is to be put; the message says which and where."""


class Observation(NamedTuple):
    """What there is to be sensed at one tick: `state` is the truth, `measured` what the odometry makes of it, `lamps` are the
    traffic lights."""

    stamp: tuple
    state: VehicleState
    measured: VehicleState
    bodies: tuple
    lamps: tuple = ()


class Simulation:
    """A car among obstacles that obeys the command in force, tick after tick.

    start: where the car stands, (x, y, yaw). command_patience_s: how long a command stays in force without a new one before
    the car brakes by itself; 0 means for ever. Latencies are rounded to whole ticks: a command reaches the car that much
    later, and `sensed` is what the world was that much earlier. Time is counted in whole ticks, so that it neither drifts nor
    depends on a clock.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        tick_s: float,
        command_patience_s: float,
        start=(0.0, 0.0, 0.0),
        obstacles: Obstacles = None,
        lights: TrafficLights = None,
        noise: OdometryNoise = None,
        ackermann: AckermannControl = None,
        command_latency_s: float = 0.0,
        sensor_latency_s: float = 0.0,
    ):
        check_between(1e-3, 1.0, tick_s=tick_s)
        check_between(0.0, 1e6, command_patience_s=command_patience_s)
        check_between(
            0.0, 100.0, command_latency_s=command_latency_s, sensor_latency_s=sensor_latency_s
        )
        self.vehicle = vehicle
        self.tick_s = tick_s
        self.tick = 1
        self.obstacles = obstacles or Obstacles()
        self.lights = lights or TrafficLights()
        self.control = CommandMux(
            round(command_patience_s / tick_s), DelayLine(command_latency_s, tick_s), ackermann
        )
        self._tick_ns = round(tick_s * _NANOSECONDS)
        self._noise = noise
        self._senses = DelayLine(sensor_latency_s, tick_s)
        self._start = start
        self._started_at = self.tick
        # From the axles' middle, which is taken for the body's, to the centre of gravity, which is the state's point.
        self._behind_m = 0.5 * (vehicle.parameters.front_axle_m - vehicle.parameters.rear_axle_m)
        self._check_free(*start)
        vehicle.reset(*start)
        self.sensed = self._sense()
        while self.sensed is None:  # the car has stood here since before the first tick
            self.tick += 1
            self.sensed = self._sense()

    @property
    def stamp(self):
        """Simulated time as (seconds, nanoseconds); the first tick is not zero, which ROS takes for 'no time yet'."""
        return divmod(self.tick * self._tick_ns, _NANOSECONDS)

    @property
    def elapsed_s(self) -> float:
        """Simulated time since the start, or the reset, of the world."""
        return (self.tick - self._started_at) * self.tick_s

    @property
    def silent(self) -> bool:
        """Whether a car that was commanded before has been without a new command for too long."""
        return self.control.silent(self.tick)

    @property
    def car(self) -> Rectangle:
        """The outline of the car on the ground."""
        state = self.vehicle.state
        return self._outline(state.x_m, state.y_m, state.yaw_rad)

    def _outline(self, x_m: float, y_m: float, yaw_rad: float) -> Rectangle:
        parameters = self.vehicle.parameters
        if self._behind_m:
            x_m, y_m = (
                x_m + self._behind_m * math.cos(yaw_rad),
                y_m + self._behind_m * math.sin(yaw_rad),
            )
        return Rectangle(x_m, y_m, yaw_rad, parameters.length_m, parameters.width_m)

    def obey(self, command: VehicleCommand, by_hand: bool = False) -> bool:
        """Take a command, clamped to its range; returns whether it had to be clamped. Raises ValueError for NaN and infinities."""
        return self.control.obey(command, self.tick, by_hand)

    def obey_ackermann(self, target: AckermannTarget) -> bool:
        """Take a speed and a wheel angle; returns whether they had to be limited. Raises ValueError for NaN and infinities."""
        return self.control.obey_ackermann(target, self.tick)

    def take_over(self, by_hand: bool) -> None:
        """A person takes the car over, or gives it back."""
        self.control.take_over(by_hand, self.tick)

    def place(self, x_m: float, y_m: float, yaw_rad: float) -> None:
        """Put the car down elsewhere, at rest, all commands forgotten.

        Raises ValueError for NaN and infinities, and where an obstacle is in the way.
        """
        self._check_free(x_m, y_m, yaw_rad)
        self.vehicle.reset(x_m, y_m, yaw_rad)
        self.control.reset()

    def reset(self) -> None:
        """Everything back to its start, but for time, which goes on."""
        self.obstacles.reset()
        self.place(*self._start)
        self._started_at = self.tick

    def memory(self) -> dict:
        """All that this world carries from tick to tick, as plain data: another one made of the same parameters goes on from it
        bit for bit."""
        return {
            "tick": self.tick,
            "started_at": self._started_at,
            "car": list(vars(self.vehicle.state).values()),
            "control": self.control.memory(),
            "obstacles": self.obstacles.memory(),
            "sensed": _plain(self.sensed),
            "senses": [_plain(snapshot) for snapshot in self._senses.items],
            "noise_draws": self._noise.draws if self._noise is not None else 0,
        }

    def recall(self, memory: dict) -> None:
        """Go on as `memory` said; to be called before the first tick. Raises KeyError, TypeError or ValueError where it is the
        memory of another kind of world."""
        self.tick, self._started_at = memory["tick"], memory["started_at"]
        self.vehicle.state = VehicleState(*memory["car"])
        self.control.recall(memory["control"])
        self.obstacles.recall(memory["obstacles"])
        self.sensed = _snapshot(memory["sensed"])
        self._senses.fill(map(_snapshot, memory["senses"]))
        if self._noise is not None:
            self._noise.skip(memory["noise_draws"] - self._noise.draws)

    def _check_free(self, x_m: float, y_m: float, yaw_rad: float) -> None:
        body = self.obstacles.at(self._outline(x_m, y_m, yaw_rad))
        if body:
            raise OccupiedError(
                f"the {body.kind} at ({body.x_m:.1f}, {body.y_m:.1f}) is where the car would stand; move one of them"
            )

    def look_again(self) -> None:
        """Sense what has been moved since the tick, as a paused world shows it; the odometry is the truth then."""
        state = self.vehicle.state
        self.sensed = self.sensed._replace(
            state=state,
            measured=state,
            bodies=self.obstacles.bodies,
            lamps=self.lights.lamps(self.elapsed_s),
        )

    def toggle_obstacle(self, plan: ObstaclePlan) -> str:
        """Put an obstacle there, or take away what is there; returns what was done. Raises ValueError where the car stands."""
        return self.obstacles.toggle(plan, self.car)

    def advance(self) -> list:
        """One tick of simulated time; returns the Touches that began in it."""
        touches = []
        if self.obstacles.all:
            touches = self.obstacles.advance(self.elapsed_s, self.tick_s, self.car)
        before = self.vehicle.state
        self.vehicle.step(self.control.command(self.tick, before, self.tick_s), self.tick_s)
        if self.obstacles.all:
            touches += self._collide(before)
        self.tick += 1
        self.sensed = self._sense() or self.sensed
        return touches

    def _collide(self, before: VehicleState) -> list:
        after = self.vehicle.state

        def way(share):
            return self._outline(*_between(before, after, share))

        touches = []
        met = self.obstacles.first_contact(way)
        if met:
            obstacle, contact = met
            approach_mps = self._stop(before, contact)
            if self.obstacles.begins_to_touch(obstacle.id):
                impulse = self.vehicle.parameters.mass_kg * approach_mps
                touches.append(
                    CollisionEvent(
                        obstacle.id, impulse * contact.normal_x, impulse * contact.normal_y
                    )
                )
        self.obstacles.release(self.car)
        return touches

    def _stop(self, before: VehicleState, contact) -> float:
        """Leave the car where it meets the body, without the part of its motion that goes into it; returns that speed."""
        after = self.vehicle.state
        x, y, yaw = _between(before, after, contact.share)
        c, s = math.cos(after.yaw_rad), math.sin(after.yaw_rad)
        along, across = (
            contact.normal_x * c + contact.normal_y * s,
            contact.normal_y * c - contact.normal_x * s,
        )
        approach_mps = max(0.0, -(after.speed_mps * along + after.lateral_speed_mps * across))
        self.vehicle.state = replace(
            after,
            x_m=x,
            y_m=y,
            yaw_rad=yaw,
            yaw_rate_radps=0.0,
            speed_mps=after.speed_mps + approach_mps * along,
            lateral_speed_mps=after.lateral_speed_mps + approach_mps * across,
            longitudinal_acceleration_mps2=0.0,
            lateral_acceleration_mps2=0.0,
            load_transfer_mps2=0.0,
        )
        return approach_mps

    def _sense(self):
        state = measured = self.vehicle.state
        if self._noise is not None:
            x, y, yaw, speed = self._noise.apply(
                state.x_m, state.y_m, state.yaw_rad, state.speed_mps
            )
            measured = replace(state, x_m=x, y_m=y, yaw_rad=yaw, speed_mps=speed)
        return self._senses.put(
            Observation(
                self.stamp,
                state,
                measured,
                self.obstacles.bodies,
                self.lights.lamps(self.elapsed_s),
            )
        )


def _between(before: VehicleState, after: VehicleState, share: float):
    return (
        before.x_m + share * (after.x_m - before.x_m),
        before.y_m + share * (after.y_m - before.y_m),
        before.yaw_rad + share * (after.yaw_rad - before.yaw_rad),
    )


def _plain(sensed: Observation) -> list:
    state, measured = sensed.state, sensed.measured
    return [
        sensed.stamp,
        list(vars(state).values()),
        None if measured is state else list(vars(measured).values()),
        [tuple(body) for body in sensed.bodies],
        [tuple(lamp) for lamp in sensed.lamps],
    ]


def _snapshot(plain: list) -> Observation:
    stamp, state, measured, bodies, lamps = plain
    state = VehicleState(*state)
    return Observation(
        tuple(stamp),
        state,
        state if measured is None else VehicleState(*measured),
        tuple(ObstacleState(*body) for body in bodies),
        tuple(TrafficLightState(*lamp) for lamp in lamps),
    )
