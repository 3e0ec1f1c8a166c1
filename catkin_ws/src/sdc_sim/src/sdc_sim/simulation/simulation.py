"""The simulation of a vehicle among obstacles and traffic lights, tick by tick."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Mapping, Sequence, Tuple

from sdc_common.driving import Observation
from sdc_common.validation import check_between
from sdc_sim.physics.ackermann import AckermannControl, AckermannGains
from sdc_sim.physics.collision import Contact, Motion, Rectangle
from sdc_sim.physics.obstacles import CollisionEvent, Obstacles
from sdc_sim.physics.traffic_lights import TrafficLightPlan, light_states
from sdc_sim.physics.vehicle import Vehicle, VehicleState
from sdc_sim.sensors.errors import DelayLine, OdometryNoise
from sdc_sim.sensors.model import Moment
from sdc_sim.sensors.suite import SensorSuite
from sdc_sim.simulation.command_mux import AnyCommand, CommandMux
from sdc_sim.simulation.snapshot import Snapshot
from sdc_sim.yaml_document import packaged_config

_NANOSECONDS = 1_000_000_000
# m/s and rad/s
_MAX_SET_SPEED = 100.0
_ORIGIN = (0.0, 0.0, 0.0)

Pose = Tuple[float, float, float]


class OccupiedError(ValueError):
    """An obstacle is at the place of the vehicle; the message names it."""


class Simulation:
    """A vehicle that executes commands among obstacles and traffic lights.

    Equal arguments and equal commands give equal observations, bit for bit. Time is a number of
    whole ticks. Latencies are rounded to whole ticks.

    Args:
        vehicle: the vehicle
        tick_s: duration of a tick
        command_timeout_s: time without a new command after which the vehicle brakes; 0 is never
        start: pose of the vehicle (x [m], y [m], yaw [rad])
        obstacles: the obstacles
        lights: the traffic lights
        noise: noise of the odometry
        ackermann: gains of the control by speed and wheel angle, those of config/sim.yaml if None
        command_latency_s: delay between a command and its execution
        sensor_latency_s: age of an observation
        sensors: further sensors
        traffic: moves other road users, such as SumoTraffic; None without them
        ground: height and pitch at a pose, Network.ground_at; None: the world is flat

    Raises:
        OccupiedError: an obstacle is at the start pose
    """

    def __init__(  # noqa: PLR0913  what is not given by name is not in the world
        self,
        vehicle: Vehicle,
        tick_s: float,
        command_timeout_s: float,
        start: Pose = _ORIGIN,
        obstacles: Obstacles | None = None,
        lights: Sequence[TrafficLightPlan] = (),
        noise: OdometryNoise | None = None,
        ackermann: AckermannGains | None = None,
        command_latency_s: float = 0.0,
        sensor_latency_s: float = 0.0,
        sensors: SensorSuite | None = None,
        traffic: Any = None,
        ground: Any = None,
    ):
        self.vehicle = vehicle
        self.tick_s = tick_s
        self.obstacles = obstacles or Obstacles()
        self.lights = lights
        gains = ackermann or AckermannGains(**packaged_config("sim")["ackermann"])
        control = AckermannControl(vehicle.parameters, gains)
        delay = DelayLine(command_latency_s, tick_s)
        self.commands = CommandMux(round(command_timeout_s / tick_s), delay, control)
        self._tick_ns = round(tick_s * _NANOSECONDS)
        self._noise = noise or OdometryNoise(0)
        self._sensors = sensors
        self.traffic = traffic
        self._sensor_line = DelayLine(sensor_latency_s, tick_s)
        self._start, self._ground = start, ground
        self.z_m = self.pitch_rad = 0.0  # of the vehicle; positive with the nose down
        # From the centre of gravity, the point of the state, forward to the centre of the body.
        self._centre_m = 0.5 * (vehicle.parameters.front_axle_m - vehicle.parameters.rear_axle_m)
        # The first stamp must not be zero, which is no time in ROS.
        self.tick = 1 + self._sensor_line.ticks
        self.reset()

    @property
    def stamp_ns(self) -> int:
        """Present simulated time [ns]."""
        return self.tick * self._tick_ns

    @property
    def elapsed_s(self) -> float:
        """Simulated time since the start or the last reset."""
        return self._elapsed_at(self.tick)

    @property
    def outline(self) -> Rectangle:
        """Outline of the vehicle on the ground."""
        state = self.vehicle.state
        return self._outline_at(state.x_m, state.y_m, state.yaw_rad)

    @property
    def observation(self) -> Observation:
        """What the car receives in this tick."""
        return self.snapshot.observation()

    def reset(self) -> Observation:
        """Restore the start and return its observation; only the time continues.

        The same commands then repeat the drive bit for bit, with later stamps.
        """
        self.obstacles.reset()
        self.place(*self._start)
        if self.traffic is not None:
            self.obstacles.move_others(self.traffic.reset(self.outline), self.outline)
        self._noise.reset()
        # The vehicle has been at its start for the time that the sensors are late.
        self._sensor_line.clear()
        self._start_tick = self.tick - self._sensor_line.ticks
        for tick in range(self._start_tick, self.tick):
            self._sense(tick)
        if self._sensors is not None:
            self._sensors.reset()
        self.snapshot = self._sense_all()
        return self.observation

    def step(self, command: AnyCommand | None = None) -> Observation:
        """Advance by one tick and return the observation after it.

        Args:
            command: software command that answers the last observation; it is limited to its
                range. None leaves the last command in force.

        Raises:
            ValueError: the command holds NaN or infinity; the simulation does not advance
        """
        if command is not None:
            self.accept(command)
        return self.observe(self.move())

    def move(self) -> list[CollisionEvent]:
        """Advance all that moves by a tick, and return the contacts that began; call `observe`."""
        collisions: list[CollisionEvent] = []
        if self.obstacles.all:
            collisions = self.obstacles.advance(self.elapsed_s, self.tick_s, self.outline)
        before = self.vehicle.state
        if self.traffic is not None:
            braking, blocked = self.commands.executed.brake > 0.0, self.obstacles.blocked
            moved = self.traffic.advance(self.outline, before.speed_mps, braking, blocked)
            collisions += self.obstacles.move_others(moved, self.outline)
        self.vehicle.step(self.commands.select(self.tick, before, self.tick_s), self.tick_s)
        if self.obstacles.all or self.obstacles.others:
            collisions += self._collide(before)
        if self._ground:
            state = self.vehicle.state
            pose = state.x_m, state.y_m, state.yaw_rad
            self.z_m, self.pitch_rad = self._ground(*pose, self.z_m)
        return collisions

    def observe(self, collisions: Sequence[CollisionEvent]) -> Observation:
        """Start the next tick with an observation of what `move` has changed, and return it."""
        self.tick += 1
        self.snapshot = self._sense_all()
        if collisions:
            self.snapshot = self.snapshot._replace(collisions=tuple(collisions))
        return self.observation

    def accept(self, command: AnyCommand, manual: bool = False) -> bool:
        """Store a command of the software or of a person for the next tick.

        Returns:
            whether the command was outside its range, to which it is limited

        Raises:
            ValueError: the command holds NaN or infinity
        """
        return self.commands.accept(command, self.tick, manual)

    def place(self, x_m: float, y_m: float, yaw_rad: float) -> None:
        """Place the vehicle at rest and forget all commands.

        Raises:
            OccupiedError: an obstacle is there
        """
        z_m, pitch_rad = self._ground(x_m, y_m, yaw_rad) if self._ground else (0.0, 0.0)
        obstacle = self.obstacles.at(self._outline_at(x_m, y_m, yaw_rad)._replace(z_m=z_m))
        if obstacle:
            raise OccupiedError(
                f"the {obstacle.kind} at ({obstacle.x_m:.1f}, {obstacle.y_m:.1f}) is at the place "
                "of the vehicle; move one of them"
            )
        self.z_m, self.pitch_rad = z_m, pitch_rad
        self.vehicle.reset(x_m, y_m, yaw_rad)
        self.commands.reset()

    def set_velocity(self, forward_mps: float, left_mps: float, yaw_rate_radps: float) -> None:
        """Set the velocity of the vehicle in its body frame; the tyres act from the next tick on.

        Raises:
            ValueError: a value is not finite or too large
        """
        motion = {"speed_mps": forward_mps, "lateral_speed_mps": left_mps}
        motion["yaw_rate_radps"] = yaw_rate_radps
        check_between(-_MAX_SET_SPEED, _MAX_SET_SPEED, **motion)
        self.vehicle.state = replace(self.vehicle.state, **motion)

    def set_disturbances(
        self, friction: float, side_wind_mps: float, odometry_noise: Mapping[str, float]
    ) -> None:
        """Set the tyres' grip, the side wind and the noise of the odometry from now on.

        Args:
            friction: factor of the grip
            side_wind_mps: positive towards the left of the vehicle
            odometry_noise: standard deviations, the arguments of OdometryNoise
        """
        self.vehicle.set_conditions(friction, side_wind_mps)
        self._noise.set_deviations(**odometry_noise)

    def observe_again(self) -> Snapshot:
        """Return the last snapshot with the present positions, without noise.

        A paused simulation shows with it what has been placed, added or removed.
        """
        state = self.vehicle.state
        self.snapshot = self.snapshot._replace(
            state=state,
            measured=state,
            obstacles=self.obstacles.states,
            traffic_lights=light_states(self.lights, self.elapsed_s),
            collisions=(),
            z_m=self.z_m,
            pitch_rad=self.pitch_rad,
        )
        return self.snapshot

    def _elapsed_at(self, tick: int) -> float:
        return (tick - self._start_tick) * self.tick_s

    def _outline_at(self, x_m: float, y_m: float, yaw_rad: float) -> Rectangle:
        parameters = self.vehicle.parameters
        if self._centre_m:
            x_m += self._centre_m * math.cos(yaw_rad)
            y_m += self._centre_m * math.sin(yaw_rad)
        return Rectangle(x_m, y_m, yaw_rad, parameters.length_m, parameters.width_m, self.z_m)

    def _sense_all(self) -> Snapshot:
        """Observe the present state with all sensors; return the snapshot to publish."""
        snapshot: Snapshot = self._sense(self.tick)
        if self._sensors is None:
            return snapshot
        tick = self.tick - self._sensor_line.ticks
        around = snapshot.obstacles, snapshot.traffic_lights
        slope = snapshot.z_m, snapshot.pitch_rad
        moment = Moment(self._elapsed_at(tick), snapshot.state, *around, *slope)
        readings = self._sensors.sense(moment, tick, tick - self._start_tick)
        return snapshot._replace(readings=readings)

    def _sense(self, tick: int) -> Any:
        """Observe the present state; return the snapshot of sensor_latency_s ago."""
        state = self.vehicle.state
        return self._sensor_line.put(
            Snapshot(
                tick * self._tick_ns,
                state,
                self._noise.apply(state),
                self.obstacles.states,
                light_states(self.lights, self._elapsed_at(tick)),
                z_m=self.z_m,
                pitch_rad=self.pitch_rad,
            )
        )

    def _collide(self, before: VehicleState) -> list[CollisionEvent]:
        """Stop the vehicle at the first obstacle on its way; return the contact that began."""
        events = []
        met = self.obstacles.first_contact(self.motion_since(before))
        if met:
            obstacle, contact = met
            impulse = self.vehicle.parameters.mass_kg * self._stop(before, contact)
            if self.obstacles.begin_contact(obstacle.id):
                push = impulse * contact.normal_x, impulse * contact.normal_y
                events.append(CollisionEvent(obstacle.id, *push))
        self.obstacles.end_contacts(self.outline)
        return events

    def motion_since(self, before: VehicleState) -> Motion:
        """Return the outline on the way from an earlier state to the present one."""
        after = self.vehicle.state
        return lambda share: self._outline_at(*_interpolated(before, after, share))

    def _stop(self, before: VehicleState, contact: Contact) -> float:
        """Move the vehicle back to the contact and remove the speed into it; return that speed."""
        approach_mps = max(0.0, -self.speed_along(contact.normal_x, contact.normal_y))
        self.push(before, contact, approach_mps)
        return approach_mps

    def speed_along(self, x: float, y: float) -> float:
        """Return the speed of the vehicle along a unit vector of the map [m/s]."""
        state = self.vehicle.state
        along, across = _in_body(state.yaw_rad, x, y)
        return state.speed_mps * along + state.lateral_speed_mps * across

    def push(self, before: VehicleState, contact: Contact, change_mps: float) -> None:
        """Move the vehicle back to a contact since `before`; change its speed along the normal."""
        after = self.vehicle.state
        x, y, yaw = _interpolated(before, after, contact.share)
        along, across = _in_body(after.yaw_rad, contact.normal_x, contact.normal_y)
        self.vehicle.state = replace(
            after,
            x_m=x,
            y_m=y,
            yaw_rad=yaw,
            yaw_rate_radps=0.0,
            speed_mps=after.speed_mps + change_mps * along,
            lateral_speed_mps=after.lateral_speed_mps + change_mps * across,
            longitudinal_acceleration_mps2=0.0,
            lateral_acceleration_mps2=0.0,
            load_transfer_mps2=0.0,
        )


def _in_body(yaw_rad: float, x: float, y: float) -> tuple[float, float]:
    """Return a vector of the map in the frame of the vehicle."""
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    return x * c + y * s, y * c - x * s


def _interpolated(before: VehicleState, after: VehicleState, share: float) -> Pose:
    return (
        before.x_m + share * (after.x_m - before.x_m),
        before.y_m + share * (after.y_m - before.y_m),
        before.yaw_rad + share * (after.yaw_rad - before.yaw_rad),
    )
