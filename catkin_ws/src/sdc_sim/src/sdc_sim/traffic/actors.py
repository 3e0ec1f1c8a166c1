"""Scripted road users: each follows a line, and acts when the car comes near. It needs no SUMO.

Those who look keep their distance with the Intelligent Driver Model: M. Treiber, A. Hennecke,
D. Helbing, "Congested traffic states in empirical observations and microscopic simulations",
Phys. Rev. E 62, 2000, eq. 3 and 4.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field
from typing import AbstractSet, Any, Iterator, Sequence

import numpy as np

from sdc_common.driving import other_level
from sdc_common.geometry.polyline import Polyline
from sdc_sim.physics.collision import Rectangle
from sdc_sim.physics.obstacles import FIRST_TRAFFIC_ID, ObstacleState
from sdc_sim.physics.traffic_lights import RED, YELLOW, TrafficLightPlan

_TIME_GAP_S = 0.9  # of the driver model
_REST_M = 2.0  # gap to the vehicle ahead at rest
_BRAKING_MPS2 = 2.5  # comfortable braking of the driver model
_HARDEST_MPS2 = 4.5  # its hardest braking
_BESIDE_M = 0.3  # a road user farther beside the way is not on it
_AT_REST_MPS = 0.5  # a slower road user is at rest
_LINE_M = 1.0  # greatest distance of a way from the stop line of its light
_ALONG = math.cos(math.radians(30.0))  # cosine of the greatest angle of a way to its light
_BEFORE_LINE_M = 1.0  # a vehicle stops at this distance before the line
_FOR_RED_MPS2 = 5.0  # hardest braking for a light
# The car moves less than this in a tick.
_WINDOW_M = 10.0


@dataclass(frozen=True)
class Actor:
    """A road user."""

    kind: str  # a key of KINDS
    path_m: np.ndarray = field(repr=False)  # (N, 2) line of its centre [m]
    start_m: float  # arc length of its start; below 0 it waits before the line, unseen
    size_m: tuple[float, float, float]  # length, width and height
    speed_mps: float = 0.0  # speed at the start, which it wants to keep
    # What it does after the trigger, in order: seconds after it, the speed that it wants then, and
    # the acceleration with which it changes its own.
    steps: tuple[tuple[float, float, float], ...] = ()
    # The trigger: the car is before this place of its mission by at most a distance and a time.
    at_m: float = math.inf
    within_m: float = 0.0
    within_s: float = 0.0
    turned_rad: float = 0.0  # heading, from that of the line
    looks: bool = True  # False: it brakes for nothing but a car at rest
    # A vehicle of a flow begins again behind the last one of its line, after gaps of these (least,
    # greatest) times, in turn.
    gaps_s: Sequence[Sequence[float]] = ()


class _Body:
    """An actor and its motion."""

    def __init__(self, number: int, actor: Actor, line: Polyline, ground: Any):
        self.id, self.actor, self.line = number, actor, line
        self._ground, self._z_m = ground, math.nan
        self.s_m = self.before_m = actor.start_m
        self.speed_mps = actor.speed_mps
        self.triggered_s: float | None = None
        self.update()

    def update(self) -> None:
        """Compute the state at the present place, None if it is not on the line."""
        self.state: ObstacleState | None = None
        s, actor = self.s_m, self.actor
        if s < 0.0:
            self._z_m = math.nan
            return
        (x, y), yaw = self.line.point_at(s), self.line.heading_at(s) + actor.turned_rad
        slope = self._ground(x, y, yaw, self._z_m) if self._ground else (0.0, 0.0)
        self._z_m, _ = slope
        row = x, y, yaw, *actor.size_m, self.speed_mps, *slope
        self.state = ObstacleState(self.id, actor.kind, *row)

    def wanted(self, time_s: float) -> tuple[float, float]:
        """Return the speed that it wants, and how fast it changes its own [m/s, m/s^2]."""
        wanted = self.actor.speed_mps, 2.0
        if self.triggered_s is not None:
            for after_s, *step in self.actor.steps:
                if time_s - self.triggered_s >= after_s:
                    wanted = step[0], step[1]
        return wanted


class ScriptedTraffic:
    """Moves actors; equal arguments and an equal car give equal motion, bit for bit.

    Args:
        actors: the road users
        mission_m: (N, 2) way of the car [m]
        seed: seed of the gaps in flows
        tick_s: duration of a tick [s]
        lights: the traffic lights, at which those who look stop
        ground: as that of Simulation
    """

    def __init__(
        self,
        actors: Sequence[Actor],
        mission_m: np.ndarray,
        seed: int,
        tick_s: float,
        lights: Sequence[TrafficLightPlan] = (),
        ground: Any = None,
    ) -> None:
        self._actors, self._seed, self._tick_s = actors, seed, tick_s
        self._mission, self._ground = Polyline(mission_m.tolist()), ground
        paths = {id(actor.path_m): actor.path_m.tolist() for actor in actors}
        self._lines = {key: Polyline(points) for key, points in paths.items()}
        self._stops: dict[int, list[tuple[float, TrafficLightPlan]]] = {}
        for line in self._lines.values():
            places = [(line.nearest(light.x_m, light.y_m), light) for light in lights]
            self._stops[id(line)] = [
                (place.s_m, light)
                for place, light in places
                if place.distance_m < _LINE_M
                and math.cos(place.heading_rad - light.heading_rad) > _ALONG
            ]

    def reset(self, ego: Rectangle) -> list[ObstacleState]:
        """Start again with the car at this place, and return the road users."""
        self._random, self._ticks, self._along_m = random.Random(self._seed), 0, 0.0
        self._bodies = [
            _Body(number, actor, self._lines[id(actor.path_m)], self._ground)
            for number, actor in enumerate(self._actors, FIRST_TRAFFIC_ID)
        ]
        self._next_id = FIRST_TRAFFIC_ID + len(self._bodies)
        return self._states()

    def advance(
        self, ego: Rectangle, speed_mps: float, braking: bool, blocked: AbstractSet[int]
    ) -> list[ObstacleState]:
        """Move the road users for a tick, and return them; see SumoTraffic.advance."""
        time_s = self._ticks * self._tick_s
        self._ticks += 1
        place = self._mission.project(ego.x_m, ego.y_m, self._along_m, _WINDOW_M, _WINDOW_M)
        self._along_m = place.s_m
        car = ObstacleState(1, "car", *ego[:5], 0.0, speed_mps, ego.z_m)
        for body in self._bodies:
            if body.id in blocked:
                body.s_m, body.speed_mps = body.before_m, 0.0
                body.update()
            actor = body.actor
            near_m = actor.within_m + actor.within_s * max(speed_mps, 1.0)
            if body.triggered_s is None and actor.at_m - self._along_m <= near_m:
                body.triggered_s = time_s
        changes = [self._acceleration_mps2(body, car, time_s) for body in self._bodies]
        for body, change in zip(self._bodies, changes):
            self._move(body, change)
        return self._states()

    def _states(self) -> list[ObstacleState]:
        return [body.state for body in self._bodies if body.state is not None]

    def _acceleration_mps2(self, body: _Body, car: ObstacleState, time_s: float) -> float:
        """Return what the driver model wants; a body at rest that wants nothing stays there."""
        speed, (wanted, rate) = body.speed_mps, body.wanted(time_s)
        if wanted == speed == 0.0 or body.s_m >= body.line.s[-1]:
            return 0.0
        free = rate * (1.0 - (speed / wanted) ** 4) if speed <= wanted else -rate
        for gap_m, ahead_mps in self._ahead(body, car, time_s):
            approach_s = (speed - ahead_mps) / (2.0 * math.sqrt(rate * _BRAKING_MPS2))
            wish_m = _REST_M + speed * max(_TIME_GAP_S + approach_s, 0.0)
            free = min(free, rate * (1.0 - (wish_m / max(gap_m, 0.1)) ** 2))
        return max(free, -max(_HARDEST_MPS2, rate))

    def _ahead(
        self, body: _Body, car: ObstacleState, time_s: float
    ) -> Iterator[tuple[float, float]]:
        """Yield distance and speed of what is ahead on the way: others, the car, a red light."""
        reach_m = 15.0 + 2.0 * body.speed_mps + body.speed_mps**2 / _BRAKING_MPS2
        looks = body.actor.looks
        others = []
        if looks:
            yield from self._on_same_line(body, reach_m)
            bodies = (other for other in self._bodies if other.line is not body.line)
            others = [other.state for other in bodies if other.state is not None]
        if looks or car.speed_mps < _AT_REST_MPS:
            others.append(car)
        if body.state is None:
            return
        for other in others:
            yield from _on_way(body, body.state, other, reach_m)
        if looks:
            yield from self._red_lights(body, reach_m, time_s)

    def _on_same_line(self, body: _Body, reach_m: float) -> Iterator[tuple[float, float]]:
        """Yield distance and speed of the bodies ahead on the line of a body."""
        for other in self._bodies:
            if other.line is body.line and 0.0 < other.s_m - body.s_m < reach_m:
                half_m = 0.5 * body.actor.size_m[0]
                yield other.s_m - body.s_m - half_m - 0.5 * other.actor.size_m[0], other.speed_mps

    def _red_lights(
        self, body: _Body, reach_m: float, time_s: float
    ) -> Iterator[tuple[float, float]]:
        """Yield distance and speed 0 of red and yellow lights at which a body can stop."""
        for line_m, light in self._stops[id(body.line)]:
            gap_m = line_m - body.s_m - 0.5 * body.actor.size_m[0] - _BEFORE_LINE_M
            can_stop = gap_m > body.speed_mps**2 / (2.0 * _FOR_RED_MPS2) - _BEFORE_LINE_M
            is_near = can_stop and 0.0 < gap_m + _BEFORE_LINE_M < reach_m
            if is_near and light.state(time_s) in (RED, YELLOW):
                yield max(gap_m, 0.1), 0.0

    def _move(self, body: _Body, change_mps2: float) -> None:
        """Move a body for a tick."""
        before_mps, body.before_m = body.speed_mps, body.s_m
        if before_mps == change_mps2 == 0.0:
            return
        body.speed_mps = max(before_mps + change_mps2 * self._tick_s, 0.0)
        body.s_m += 0.5 * (before_mps + body.speed_mps) * self._tick_s
        if body.s_m >= body.line.s[-1]:
            if body.actor.gaps_s:
                self._begin_again(body)
            else:
                body.s_m, body.speed_mps = body.line.s[-1], 0.0
        body.update()

    def _begin_again(self, body: _Body) -> None:
        """Place a vehicle of a flow behind the last one, as another road user."""
        gaps_s, speed_mps = body.actor.gaps_s, body.actor.speed_mps
        gap_s = self._random.uniform(*gaps_s[self._next_id % len(gaps_s)])
        last_m = min(0.0, *(vehicle.s_m for vehicle in self._bodies if vehicle.line is body.line))
        body.s_m = body.before_m = last_m - body.actor.size_m[0] - gap_s * speed_mps
        body.speed_mps, body.id = speed_mps, self._next_id
        self._next_id += 1


def _on_way(
    body: _Body, state: ObstacleState, other: ObstacleState, reach_m: float
) -> Iterator[tuple[float, float]]:
    """Yield distance and speed of another road user if it is ahead on the way of a body.

    Args:
        body: the body
        state: where it is
        other: the other road user
        reach_m: distance within which it matters [m]
    """
    reach_m += other.length_m
    if abs(other.x_m - state.x_m) > reach_m or abs(other.y_m - state.y_m) > reach_m:
        return
    length_m, width_m = body.actor.size_m[:2]
    place = body.line.project(other.x_m, other.y_m, body.s_m, 0.0, reach_m)
    turned = other.yaw_rad - place.heading_rad
    cos, sin = math.cos(turned), abs(math.sin(turned))
    across_m = 0.5 * (other.length_m * sin + other.width_m * abs(cos) + width_m)
    on_level = not other_level(other.z_m, state.z_m, place.s_m - body.s_m)
    if on_level and place.distance_m < across_m + _BESIDE_M and place.s_m > body.s_m:
        along_m = 0.5 * (other.length_m * abs(cos) + other.width_m * sin)
        yield place.s_m - body.s_m - along_m - 0.5 * length_m, other.speed_mps * cos
