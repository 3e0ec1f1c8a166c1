"""What stands and moves on the road beside the car: boxes the size of cars, pedestrians and things."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from sdc_sim.physics.collision import Contact, Rectangle, first_contact, overlap

# Numbers of the bodies, as CollisionEvent gives them; the car itself is 1.
FIRST_ID = 101
# A contact is over when the bodies are this far apart: one touch is one event, however it trembles.
RELEASE_M = 0.1


class ObstacleKind(NamedTuple):
    """What a kind of obstacle is like, where the scenario does not say otherwise."""

    length_m: float
    width_m: float
    height_m: float
    mass_kg: float


KINDS = {
    "car": ObstacleKind(4.7, 2.0, 1.45, 1800.0),
    "pedestrian": ObstacleKind(0.5, 0.5, 1.75, 75.0),
    "obstacle": ObstacleKind(1.0, 1.0, 1.0, 200.0),
}


class ObstacleState(NamedTuple):
    """An obstacle at one moment: metres, radians, m/s, in the map."""

    id: int
    kind: str
    x_m: float
    y_m: float
    yaw_rad: float
    length_m: float
    width_m: float
    height_m: float
    speed_mps: float

    @property
    def rectangle(self) -> Rectangle:
        """Its outline on the ground."""
        return Rectangle(self.x_m, self.y_m, self.yaw_rad, self.length_m, self.width_m)


class CollisionEvent(NamedTuple):
    """A contact that has just begun: with which body, and the impulse on the car (N s, in the map)."""

    id: int
    impulse_x_ns: float
    impulse_y_ns: float


@dataclass(frozen=True)
class ObstaclePlan:
    """An obstacle as a scenario describes it: (x, y) in the map, one point for a standing body, more for a moving one.

    A moving body waits at its first point until start_s after the start (or the reset) of the world, or, with trigger_m, until
    the car is that near; it moves on straight lines and stays at the last point. yaw_rad counts for a standing body only.
    """

    kind: str
    points_m: tuple
    size_m: tuple
    yaw_rad: float = 0.0
    speed_mps: float = 0.0
    start_s: float = 0.0
    trigger_m: float = None

    @staticmethod
    def standing(kind: str, x_m: float, y_m: float, yaw_rad: float) -> ObstaclePlan:
        """A body of the kind's own size."""
        return ObstaclePlan(kind, ((x_m, y_m),), KINDS[kind][:3], yaw_rad)


def _plan_from(kind, points_m, size_m, *rest) -> ObstaclePlan:
    return ObstaclePlan(kind, tuple(map(tuple, points_m)), tuple(size_m), *rest)


class SimulatedObstacle:
    """One body and how far it has come along its plan."""

    def __init__(self, number: int, plan: ObstaclePlan):
        self.id = number
        self.plan = plan
        legs = list(zip(plan.points_m, plan.points_m[1:]))
        self._lengths = [math.hypot(b[0] - a[0], b[1] - a[1]) for a, b in legs]
        self._yaws = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in legs] or [plan.yaw_rad]
        self._path_m = sum(self._lengths)
        self.reset()

    def reset(self) -> None:
        """Back to the first point, waiting."""
        self.travelled_m = 0.0
        self.started = False
        self.speed_mps = 0.0
        self.body = self.body_at(0.0)

    def memory(self) -> list:
        """How far it has come, as plain data; its plan is not in it."""
        return [self.id, self.travelled_m, self.started, self.speed_mps]

    def recall(self, travelled_m: float, started: bool, speed_mps: float) -> None:
        """Be as far as `memory` said."""
        self.travelled_m, self.started, self.speed_mps = travelled_m, started, speed_mps
        self.body = self.body_at(travelled_m)

    def body_at(self, travelled_m: float) -> ObstacleState:
        """The body after that much of its path."""
        x, y = self.plan.points_m[0]
        yaw = self._yaws[0]
        left = travelled_m
        for start, length, leg_yaw in zip(self.plan.points_m, self._lengths, self._yaws):
            x, y, yaw = start[0], start[1], leg_yaw
            if left <= length:
                break
            x, y = x + length * math.cos(yaw), y + length * math.sin(yaw)
            left -= length
            length = 0.0
        else:
            left = 0.0
        return ObstacleState(
            self.id,
            self.plan.kind,
            x + left * math.cos(yaw),
            y + left * math.sin(yaw),
            yaw,
            *self.plan.size_m,
            self.speed_mps,
        )

    def advance(self, elapsed_s: float, step_s: float, car: Rectangle) -> Contact | None:
        """Move on for step_s, not into the car; returns the contact that stopped it, if one did."""
        if not self._lengths:
            return None
        if not self.started:
            self.started = self._may_start(elapsed_s, car)
        ahead = (
            min(self.plan.speed_mps * step_s, self._path_m - self.travelled_m)
            if self.started
            else 0.0
        )
        contact = None
        if ahead > 0.0:
            here = self.travelled_m
            contact = first_contact(lambda share: self.body_at(here + share * ahead).rectangle, car)
            ahead *= contact.share if contact else 1.0
            self.travelled_m += ahead
        self.speed_mps = 0.0 if contact else ahead / step_s
        self.body = self.body_at(self.travelled_m)
        return contact

    def _may_start(self, elapsed_s: float, car: Rectangle) -> bool:
        if self.plan.trigger_m is None:
            return elapsed_s >= self.plan.start_s - 1e-9
        return math.hypot(car.x_m - self.body.x_m, car.y_m - self.body.y_m) <= self.plan.trigger_m


class Obstacles:
    """All of them: they move, hold the car up, and come and go by a click."""

    def __init__(self, plans=()):
        self._planned = [
            SimulatedObstacle(FIRST_ID + number, plan) for number, plan in enumerate(plans)
        ]
        self._next_id = FIRST_ID + len(self._planned)
        self.all = list(self._planned)
        self._touching = set()

    @property
    def bodies(self) -> tuple:
        """Every Body as it is now."""
        return tuple(obstacle.body for obstacle in self.all)

    def at(self, place: Rectangle) -> ObstacleState | None:
        """A body that lies on this place, or None."""
        return next(
            (obstacle.body for obstacle in self.all if overlap(obstacle.body.rectangle, place)),
            None,
        )

    def reset(self) -> None:
        """As at the start: what was added by a click goes, what was removed comes back."""
        self.all = list(self._planned)
        self._touching = set()
        for obstacle in self.all:
            obstacle.reset()

    def memory(self) -> dict:
        """Where they all are, as plain data."""
        planned = set(self._planned)
        return {
            "next_id": self._next_id,
            "touching": sorted(self._touching),
            "all": [
                [
                    *obstacle.memory(),
                    None if obstacle in planned else list(vars(obstacle.plan).values()),
                ]
                for obstacle in self.all
            ],
        }

    def recall(self, memory: dict) -> None:
        """Be as `memory` said; the obstacles of the scenario must be the same."""
        planned = {obstacle.id: obstacle for obstacle in self._planned}
        self.all = []
        for number, travelled_m, started, speed_mps, plan in memory["all"]:
            obstacle = SimulatedObstacle(number, _plan_from(*plan)) if plan else planned[number]
            obstacle.recall(travelled_m, started, speed_mps)
            self.all.append(obstacle)
        self._next_id = memory["next_id"]
        self._touching = set(memory["touching"])

    def toggle(self, plan: ObstaclePlan, car: Rectangle) -> str:
        """Remove the obstacles within half a metre of the plan's point, or put the planned one there; returns what was done.

        Raises ValueError where the car is in the way.
        """
        x, y = plan.points_m[0]
        point = Rectangle(x, y, 0.0, 1.0, 1.0)
        hit = [obstacle for obstacle in self.all if overlap(obstacle.body.rectangle, point)]
        if hit:
            self.all = [obstacle for obstacle in self.all if obstacle not in hit]
            return f"removed {len(hit)} at ({x:.1f}, {y:.1f})"
        obstacle = SimulatedObstacle(self._next_id, plan)
        if overlap(obstacle.body.rectangle, car):
            raise ValueError(f"the car stands at ({x:.1f}, {y:.1f})")
        self._next_id += 1
        self.all.append(obstacle)
        return f"put one {plan.kind} at ({x:.1f}, {y:.1f})"

    def advance(self, elapsed_s: float, step_s: float, car: Rectangle) -> list:
        """Move them all for step_s while the car stands still; returns the Touches that began.

        What walks into the car gives it the momentum it loses.
        """
        touches = []
        for obstacle in self.all:
            contact = obstacle.advance(elapsed_s, step_s, car)
            if contact and obstacle.id not in self._touching:
                yaw, speed = obstacle.body.yaw_rad, obstacle.plan.speed_mps
                approach = -speed * (
                    math.cos(yaw) * contact.normal_x + math.sin(yaw) * contact.normal_y
                )
                impulse = -KINDS[obstacle.plan.kind].mass_kg * max(approach, 0.0)
                touches.append(
                    CollisionEvent(
                        obstacle.id, impulse * contact.normal_x, impulse * contact.normal_y
                    )
                )
                self._touching.add(obstacle.id)
        return touches

    def first_contact(self, way):
        """(obstacle, Contact) of the first that the car meets on its way (see collision.first_contact), or None."""
        met = None
        for obstacle in self.all:
            contact = first_contact(way, obstacle.body.rectangle)
            if contact and (met is None or contact.share < met[1].share):
                met = obstacle, contact
        return met

    def begins_to_touch(self, number: int) -> bool:
        """Note a contact of the car with this obstacle; returns whether it is a new one."""
        if number in self._touching:
            return False
        self._touching.add(number)
        return True

    def release(self, car: Rectangle) -> None:
        """Forget the contacts that are over."""
        if self._touching:
            near = car.grown(RELEASE_M)
            self._touching = {
                obstacle.id
                for obstacle in self.all
                if obstacle.id in self._touching and overlap(near, obstacle.body.rectangle)
            }
