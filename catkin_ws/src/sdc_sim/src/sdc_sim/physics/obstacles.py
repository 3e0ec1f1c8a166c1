"""Obstacles: boxes of the size of cars, pedestrians and objects that are or move on the road."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, Iterable, NamedTuple, Sequence

from sdc_common.geometry.polyline import Polyline
from sdc_sim.physics.collision import Contact, Motion, Rectangle, first_contact, overlap
from sdc_sim.yaml_document import packaged_config

# First IDs in messages of the obstacles and of the traffic; the ego vehicle is 1.
FIRST_ID, FIRST_TRAFFIC_ID = 101, 10001
# Length of the path of an obstacle that moves straight on.
_FAR_M = 1e4
# A contact ends at this distance: a trembling contact is one event.
RELEASE_M = 0.1


# The kinds of obstacles as attributes; config/obstacle_kinds.yaml describes them.
KINDS: dict[str, Any] = {
    name: SimpleNamespace(**row) for name, row in packaged_config("obstacle_kinds").items()
}


class ObstacleState(NamedTuple):
    """An obstacle at one time, in the map."""

    id: int
    kind: str
    x_m: float
    y_m: float
    yaw_rad: float
    length_m: float
    width_m: float
    height_m: float
    speed_mps: float
    z_m: float = 0.0  # height of the ground below it
    pitch_rad: float = 0.0  # positive with the nose down

    @property
    def size_m(self) -> tuple[float, float, float]:
        """Length, width and height."""
        return self.length_m, self.width_m, self.height_m

    @property
    def rectangle(self) -> Rectangle:
        """Outline on the ground."""
        return Rectangle(*self[2:7], self.z_m)


class CollisionEvent(NamedTuple):
    """The start of a contact: ID of the obstacle, impulse on the ego vehicle in the map [N s]."""

    id: int
    impulse_x_ns: float
    impulse_y_ns: float


@dataclass(frozen=True)
class ObstaclePlan:
    """An obstacle in a scenario.

    A moving obstacle waits at its first point, moves along straight lines, and stops at the last
    point.
    """

    kind: str  # a key of KINDS
    # Points (x, y) in the map; one for a stationary obstacle, more for a moving one.
    points_m: tuple[tuple[float, float], ...]
    size_m: tuple[float, float, float]  # length, width and height
    yaw_rad: float = 0.0  # heading of a stationary obstacle
    speed_mps: float = 0.0  # speed of a moving obstacle
    # Time after the start, or the reset, of the simulation at which it starts to move.
    start_s: float = 0.0
    # It starts when the ego vehicle is this near, in place of start_s.
    trigger_m: float | None = None

    @staticmethod
    def stationary(kind: str, x_m: float, y_m: float, yaw_rad: float) -> ObstaclePlan:
        """Return a stationary obstacle with the default size of its kind."""
        return ObstaclePlan(kind, ((x_m, y_m),), KINDS[kind].size_m, yaw_rad)

    def straight_on(self, yaw_rad: float, speed_mps: float) -> ObstaclePlan:
        """Return the plan of an obstacle that moves from its first point until it is changed."""
        x, y = self.points_m[0]
        if not speed_mps:
            return replace(self, points_m=((x, y),), yaw_rad=yaw_rad)
        far = x + _FAR_M * math.cos(yaw_rad), y + _FAR_M * math.sin(yaw_rad)
        return replace(self, points_m=((x, y), far), speed_mps=speed_mps, start_s=0.0)


class SimulatedObstacle:
    """One obstacle and its progress along its plan, on the ground of `Network.ground_at`."""

    def __init__(self, number: int, plan: ObstaclePlan, ground: Any = None):
        self.id = number
        self.plan = plan
        self._path = Polyline(plan.points_m) if len(plan.points_m) > 1 else None
        self.travelled_m = 0.0
        self.started = False
        self.speed_mps = 0.0
        self._ground, self._z_m = ground, math.nan
        self.body = self.body_at(0.0)

    def body_at(self, travelled_m: float) -> ObstacleState:
        """Return the obstacle after this distance along its path."""
        if self._path is None:
            (x, y), yaw = self.plan.points_m[0], self.plan.yaw_rad
        else:
            s = min(travelled_m, self._path.s[-1])
            (x, y), yaw = self._path.point_at(s), self._path.direction_at(s)
        slope = self._ground(x, y, yaw, self._z_m) if self._ground else (0.0, 0.0)
        row = x, y, yaw, *self.plan.size_m, self.speed_mps, *slope
        return ObstacleState(self.id, self.plan.kind, *row)

    def advance(self, elapsed_s: float, step_s: float, ego: Rectangle) -> Contact | None:
        """Move for step_s, but not into the ego vehicle.

        Returns:
            the contact that stopped it, None without one
        """
        if self._path is None:
            return None
        if not self.started:
            self.started = self._may_start(elapsed_s, ego)
        contact, from_m, ahead = None, self.travelled_m, 0.0
        if self.started:
            ahead = distance = min(self.plan.speed_mps * step_s, self._path.s[-1] - from_m)
        if ahead > 0.0:
            contact = first_contact(
                lambda share: self.body_at(from_m + share * distance).rectangle, lambda _: ego
            )
            ahead *= contact.share if contact else 1.0
            self.travelled_m += ahead
        self.speed_mps = 0.0 if contact else ahead / step_s
        self._z_m = self.body.z_m
        self.body = self.body_at(self.travelled_m)
        return contact

    def _may_start(self, elapsed_s: float, ego: Rectangle) -> bool:
        if self.plan.trigger_m is None:
            return elapsed_s >= self.plan.start_s - 1e-9
        return math.hypot(ego.x_m - self.body.x_m, ego.y_m - self.body.y_m) <= self.plan.trigger_m


class Obstacles:
    """All obstacles of a simulation: they move, stop the ego vehicle, and are added and removed."""

    def __init__(self, plans: Iterable[ObstaclePlan] = (), ground: Any = None):
        self._plans, self._ground = tuple(plans), ground
        self._next_id = FIRST_ID + len(self._plans)
        self.reset()

    @property
    def states(self) -> tuple[ObstacleState, ...]:
        """All obstacles at the present time."""
        return (*[obstacle.body for obstacle in self.all], *self.others)

    def at(self, place: Rectangle) -> ObstacleState | None:
        """Return an obstacle that overlaps this place, None if it is free."""
        return next((state for state in self.states if overlap(state.rectangle, place)), None)

    def reset(self) -> None:
        """Restore the obstacles of the scenario: added ones go, removed ones return."""
        # Those that move by a plan, and bodies that something else moves.
        self.all = [
            SimulatedObstacle(number, plan, self._ground)
            for number, plan in enumerate(self._plans, FIRST_ID)
        ]
        self._touching: set[int] = set()
        self.others: tuple[ObstacleState, ...] = ()
        self.blocked: frozenset[int] = frozenset()  # ids that the ego vehicle has stopped

    def toggle(self, plan: ObstaclePlan, ego: Rectangle) -> str:
        """Remove the obstacles within 0.5 m of the plan's point, or add the plan if there is none.

        Returns:
            a text that describes the change

        Raises:
            ValueError: as `add`
        """
        x, y = plan.points_m[0]
        point = Rectangle(x, y, 0.0, 1.0, 1.0)
        hit = [obstacle for obstacle in self.all if overlap(obstacle.body.rectangle, point)]
        if hit:
            self.all = [obstacle for obstacle in self.all if obstacle not in hit]
            return f"removed {len(hit)} at ({x:.1f}, {y:.1f})"
        self.add(plan, ego)
        return f"added one {plan.kind} at ({x:.1f}, {y:.1f})"

    def add(self, plan: ObstaclePlan, ego: Rectangle) -> int:
        """Add an obstacle and return its ID.

        Raises:
            ValueError: the ego vehicle is there
        """
        obstacle = SimulatedObstacle(self._next_id, plan, self._ground)
        if overlap(obstacle.body.rectangle, ego):
            x, y = plan.points_m[0]
            raise ValueError(f"the ego vehicle is at ({x:.1f}, {y:.1f}); choose another place")
        self._next_id += 1
        self.all.append(obstacle)
        return obstacle.id

    def change(self, number: int, motion: tuple[float, float] | None) -> None:
        """Let an obstacle move straight on, heading [rad] and speed [m/s], or with None remove it.

        Raises:
            ValueError: there is no obstacle with this ID
        """
        ids = [obstacle.id for obstacle in self.all]
        if number not in ids:
            raise ValueError(f"there is no obstacle {number}")
        index = ids.index(number)
        body, plan = self.all[index].body, self.all[index].plan
        del self.all[index]
        if motion:
            plan = replace(plan, points_m=((body.x_m, body.y_m),)).straight_on(*motion)
            self.all.insert(index, SimulatedObstacle(number, plan, self._ground))

    def advance(self, elapsed_s: float, step_s: float, ego: Rectangle) -> list[CollisionEvent]:
        """Move all obstacles for step_s while the ego vehicle does not move.

        Returns:
            the contacts that began; an obstacle transfers its momentum to the ego vehicle
        """
        events = []
        for obstacle in self.all:
            contact = obstacle.advance(elapsed_s, step_s, ego)
            if contact and self.begin_contact(obstacle.id):
                moving = obstacle.body._replace(speed_mps=obstacle.plan.speed_mps)
                events.append(_push(moving, contact.normal_x, contact.normal_y))
        return events

    def move_others(self, states: Sequence[ObstacleState], ego: Rectangle) -> list[CollisionEvent]:
        """Set the bodies that something else moves; none of them moves into the ego vehicle.

        Returns:
            the contacts that began
        """
        before, events, moved, blocked = {state.id: state for state in self.others}, [], [], set()
        for state in states:
            met = overlap(state.rectangle, ego) if _is_within(0.0, state, ego) else None
            if not met:
                moved.append(state)
            elif state.id in before:  # a body that begins there is not on the road yet
                blocked.add(state.id)
                moved.append(before[state.id]._replace(speed_mps=0.0))
                if self.begin_contact(state.id):
                    events.append(_push(state, met[1], met[2]))
        self.others, self.blocked = tuple(moved), frozenset(blocked)
        return events

    def first_contact(self, motion: Motion) -> tuple[ObstacleState, Contact] | None:
        """Return the obstacle and the contact that first stop this motion, None if it is free."""
        first, start, end = None, motion(0.0), motion(1.0)
        way_m = math.hypot(end.x_m - start.x_m, end.y_m - start.y_m)
        near = [state for state in self.states if _is_within(way_m, state, start)]
        for body in near:
            contact = first_contact(motion, lambda _: body.rectangle)  # noqa: B023
            if contact and (first is None or contact.share < first[1].share):
                first = body, contact
        return first

    def begin_contact(self, number: int) -> bool:
        """Record a contact with this obstacle; return whether it is a new one."""
        if number in self._touching:
            return False
        self._touching.add(number)
        return True

    def end_contacts(self, ego: Rectangle) -> None:
        """Forget the contacts that are over."""
        if self._touching:
            near = ego.grown(RELEASE_M)
            self._touching = {
                body.id
                for body in self.states
                if body.id in self._touching
                and (body.id in self.blocked or overlap(near, body.rectangle))
            }


def _is_within(way_m: float, body: ObstacleState, ego: Rectangle) -> bool:
    """Return False only for a body that the ego vehicle cannot meet on a way of this length."""
    reach_m = way_m + body.length_m + body.width_m + ego.length_m + ego.width_m
    return abs(body.x_m - ego.x_m) < reach_m and abs(body.y_m - ego.y_m) < reach_m


def _push(body: ObstacleState, x: float, y: float) -> CollisionEvent:
    """Return the contact of a moving body that pushes the ego vehicle along a normal."""
    approach = -body.speed_mps * (math.cos(body.yaw_rad) * x + math.sin(body.yaw_rad) * y)
    impulse = -KINDS[body.kind].mass_kg * max(approach, 0.0)
    return CollisionEvent(body.id, impulse * x, impulse * y)
