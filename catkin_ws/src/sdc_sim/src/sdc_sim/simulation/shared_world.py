"""Several cars in one world: a simulation for each, in which the others are obstacles.

All cars advance from the states before the tick, so their order has no influence. Then those that
met exchange momentum, and each car observes where the others are.
"""

from __future__ import annotations

import math
from functools import partial
from itertools import combinations
from types import SimpleNamespace
from typing import Any, Callable, Mapping

from sdc_sim.physics.collision import Contact, first_contact, overlap
from sdc_sim.physics.obstacles import KINDS, CollisionEvent, ObstacleState
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.simulation.command_mux import AnyCommand
from sdc_sim.simulation.loop import Driver, Evaluation
from sdc_sim.simulation.simulation import OccupiedError, Simulation
from sdc_sim.simulation.snapshot import Snapshot

MOST_CARS = 8
_ARRIVED_M = 2.0  # a car at rest within this distance of the end of the way has arrived
_AT_REST_MPS = 0.05


class SharedWorld:
    """Several cars on one road; equal commands give equal observations, bit for bit.

    The id of a car is its place in `cars`, from 1. A car that has arrived or collided, which ends
    its drive, leaves the road: the others neither see nor meet it.

    Args:
        cars: the simulations by the names of the cars, all with the same tick
        end_m: end of the way, where cars arrive (x, y); None without an end [m]

    Raises:
        OccupiedError: two cars start at the same place
    """

    def __init__(
        self, cars: Mapping[str, Simulation], end_m: tuple[float, float] | None = None
    ) -> None:
        self.cars = dict(cars)
        self.first = next(iter(self.cars.values()))
        self.tick_s = self.first.tick_s
        self._end_m = end_m
        self._ids = {name: number for number, name in enumerate(self.cars, 1)}
        for name, car in self.cars.items():
            # While they move there is none: `_meet` finds those that meet.
            start = partial(lambda name, _ego: self._others(name), name)
            car.traffic = SimpleNamespace(reset=start, advance=lambda *_: [])
        self.reset()
        for name, other in combinations(self.cars, 2):
            if overlap(self.cars[name].outline, self.cars[other].outline):
                raise OccupiedError(f"{name} and {other} start at the same place; move one of them")

    @property
    def tick(self) -> int:
        """Number of the tick."""
        return self.first.tick

    def reset(self) -> None:
        """Restore the start; see Simulation.reset."""
        self.on_road = dict.fromkeys(self.cars)  # names of the cars, in order
        for car in (*self.cars.values(), *self.cars.values()):
            car.reset()  # The second time, all others are at their start.

    def leave(self, name: str) -> None:
        """Take a car off the road; it may drive on where no other one is."""
        self.on_road.pop(name, None)

    def step(self, commands: Mapping[str, AnyCommand | None] | None = None) -> None:
        """Advance by one tick.

        Args:
            commands: those that answer the last observations; see Simulation.step
        """
        for name, command in (commands or {}).items():
            if command is not None:
                self.cars[name].accept(command)
        before = {name: car.vehicle.state for name, car in self.cars.items()}
        events = {name: car.move() for name, car in self.cars.items()}
        self._meet(before, events)
        for name, car in self.cars.items():
            car.obstacles.others = tuple(self._others(name))
            car.observe(events[name])
        for name, car in self.cars.items():
            if events[name] or self._has_arrived(car):
                self.leave(name)

    def observe_again(self) -> None:
        """Observe the present positions; see Simulation.observe_again."""
        for name, car in self.cars.items():
            car.obstacles.others = tuple(self._others(name))
            car.observe_again()

    def _has_arrived(self, car: Simulation) -> bool:
        state = car.vehicle.state
        speed_mps = math.hypot(state.speed_mps, state.lateral_speed_mps)
        if self._end_m is None or speed_mps >= _AT_REST_MPS:
            return False
        return math.dist(self._end_m, (state.x_m, state.y_m)) < _ARRIVED_M

    def _others(self, name: str) -> list[ObstacleState]:
        on_road = [other for other in self.on_road if other != name] if name in self.on_road else []
        return [self._state(other) for other in on_road]

    def _state(self, name: str) -> ObstacleState:
        car, (*_, height_m) = self.cars[name], KINDS["car"].size_m
        speed_mps = car.vehicle.state.speed_mps
        *body, z_m = car.outline
        row = *body, height_m, speed_mps, z_m, car.pitch_rad
        return ObstacleState(self._ids[name], "car", *row)

    def _meet(
        self, before: Mapping[str, VehicleState], events: Mapping[str, list[CollisionEvent]]
    ) -> None:
        """Let cars that met stop at their contact; a car meets one other in a tick, the first."""
        # Their places, which do not depend on the order of the cars, decide about equal contacts.
        names = sorted(self.on_road, key=lambda name: (before[name].x_m, before[name].y_m))
        ways = {name: self.cars[name].motion_since(before[name]) for name in names}
        contacts: list[tuple[float, int, str, str, Contact]] = []
        for first, second in combinations(names, 2):
            contact = first_contact(ways[first], ways[second])
            if contact is not None:
                contacts.append((contact.share, len(contacts), first, second, contact))
        met: set[str] = set()
        for *_, first, second, contact in sorted(contacts):
            if not met & {first, second}:
                met |= {first, second}
                impulse_ns = self._impulse_ns(first, second, contact)
                for name, seen, sign in ((first, second, 1.0), (second, first, -1.0)):
                    car, push_ns = self.cars[name], sign * impulse_ns
                    push = push_ns * contact.normal_x, push_ns * contact.normal_y
                    events[name].append(CollisionEvent(self._ids[seen], *push))
                    car.push(before[name], contact, push_ns / car.vehicle.parameters.mass_kg)

    def _impulse_ns(self, first: str, second: str, contact: Contact) -> float:
        """Return the impulse after which two cars have one speed along the normal of a contact."""
        cars = self.cars[first], self.cars[second]
        speeds = [car.speed_along(contact.normal_x, contact.normal_y) for car in cars]
        masses = [car.vehicle.parameters.mass_kg for car in cars]
        return max(0.0, speeds[1] - speeds[0]) * masses[0] * masses[1] / sum(masses)


def race(
    world: SharedWorld,
    drivers: Mapping[str, Driver],
    evaluations: Mapping[str, Evaluation],
    longest_s: float | None = None,
    observe: Callable[[Mapping[str, Snapshot]], Any] | None = None,
) -> None:
    """Drive several cars tick by tick until the drives of all of them have ended.

    A car whose drive has ended leaves the road.

    Args:
        world: the world at its start
        drivers: the software of each car, by its name
        evaluations: each watches the drive of its car
        longest_s: simulated time after which to stop, None for no limit [s]
        observe: called with the true states of the cars whose drives have not ended, in each tick
    """
    driving = list(drivers)
    while driving:
        snapshots = {name: world.cars[name].snapshot for name in driving}
        if observe is not None:
            observe(snapshots)
        commands = {name: drivers[name].step(snapshots[name].observation()) for name in snapshots}
        for name, snapshot in snapshots.items():
            if evaluations[name].add(snapshot, commands[name], drivers[name]):
                driving.remove(name)
                world.leave(name)
        if longest_s is not None and world.first.elapsed_s >= longest_s:
            return
        world.step(commands)
