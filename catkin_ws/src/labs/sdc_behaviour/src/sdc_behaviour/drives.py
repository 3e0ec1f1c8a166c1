"""Drives in traffic on the road of the lab, in one process.

python3 -m sdc_behaviour.drives [lorry|brake|crossing] [SEED ...] drives with what you have written.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, field
from typing import Any, Callable

import numpy as np

from sdc_behaviour.driver import SPACE_M, BehaviourDriver, LaneRoad
from sdc_behaviour.junction import NEVER
from sdc_behaviour.manoeuvre import LaneProposal, LaneScene, choose, gap_m, one_ahead
from sdc_behaviour.roads import END_M, LINES, ROAD, SIDE_FROM_M, SIDE_M, WIDTH_M, crossing_road
from sdc_common.driving import Observation, Path
from sdc_sim.physics.ackermann import AckermannTarget
from sdc_sim.physics.obstacles import KINDS
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.physics.vehicle_parameters import load_vehicle
from sdc_sim.simulation.loop import drive
from sdc_sim.simulation.simulation import Simulation
from sdc_sim.simulation.snapshot import Snapshot
from sdc_sim.traffic.actors import Actor, ScriptedTraffic
from sdc_sim.yaml_document import config_path

TICK_S = 0.05
_WHEELBASE_M = 2.87
BEFORE_M = 200.0  # ways of road users begin at this distance before the start of the road
WAYS_M = (
    np.array([(-BEFORE_M, 0.0), (END_M, 0.0)]),
    np.array([(-BEFORE_M, WIDTH_M), (END_M, WIDTH_M)]),
    np.array([(SIDE_M, SIDE_FROM_M + BEFORE_M), (SIDE_M, -SIDE_FROM_M)]),
)
START_M = 10.0  # place on the road at which a drive starts
FINISH_M = 620.0  # place on the road at which a drive ends
LONGEST_S = 150.0


@dataclass
class Driven:
    """A drive, and what the referee of the lab counts."""

    collisions: int = 0  # collisions of the car
    # Road users with right of way that were in the space that both need together with the car, or
    # within 1 s after it
    taken: int = 0
    # Greatest deceleration of a vehicle behind the car because of the car [m/s^2]
    pushed_mps2: float = 0.0
    mean_mps: float = 0.0  # mean speed from start to finish; 0 if it did not arrive [m/s]
    # (T, 5) time [s], place [m], speed [m/s], gap to the vehicle ahead [m], distance from the
    # middle of the right lane [m]
    rows: np.ndarray = field(default_factory=lambda: np.empty((0, 5)), repr=False)


def _actor(way: int, from_m: float, mps: float, kind: str = "car", **options: Any) -> Actor:
    """Return a road user on lane 0 or 1 of the road, or on the side road, number 2."""
    size_m = KINDS[kind].size_m
    # The side road's users do not brake for the car, which must not be in their way.
    return Actor(kind, WAYS_M[way], BEFORE_M + from_m, size_m, mps, looks=way < 2, **options)


def _lorry(random: np.random.Generator) -> list[Actor]:
    """Return a slow lorry ahead, and cars in the left lane."""
    places = np.cumsum(random.uniform(25.0, 80.0, 5)) - 130.0
    speeds = random.uniform(12.0, 13.5, 5)
    lorry = _actor(0, random.uniform(60.0, 90.0), random.uniform(5.0, 7.0), "lorry")
    return [lorry, *(_actor(1, *vehicle) for vehicle in zip(places.tolist(), speeds.tolist()))]


def _brake(random: np.random.Generator) -> list[Actor]:
    """Return a column ahead, whose first car brakes hard to a stop, and a full left lane."""
    stops = (0.0, 0.0, 8.0), (random.uniform(3.0, 5.0), 12.0, 1.5)
    first = _actor(0, 75.0, 12.0, steps=stops, at_m=random.uniform(80.0, 250.0))
    return [first, _actor(0, 45.0, 12.0), *(_actor(1, 30.0 * n - 60.0, 11.5) for n in range(8))]


def _crossing(random: np.random.Generator) -> list[Actor]:
    """Return cars on the side road with right of way, 2.5 s to 6 s apart."""
    speed = random.uniform(8.0, 11.0)
    meets_s = 16.0 + np.cumsum(random.uniform(2.5, 6.0, 6))
    return [_actor(2, SIDE_FROM_M - speed * moment_s, speed) for moment_s in meets_s.tolist()]


SCENES: dict[str, Callable[[np.random.Generator], list[Actor]]] = {
    "lorry": _lorry,
    "brake": _brake,
    "crossing": _crossing,
}


class LabCar:
    """The driver of the lab with a simple controller: pure pursuit, and its acceleration."""

    path: Path | None = None
    reason = ""

    def __init__(self, planner: BehaviourDriver):
        self._planner = planner

    def step(self, observation: Observation) -> AckermannTarget:
        """Return the command that answers an observation."""
        path, seen = self._planner.plan(observation), observation
        ahead_m = 4.0 + 0.6 * seen.speed_mps
        x, y, _ = min(
            path.points, key=lambda point: abs(math.dist(point[:2], (seen.x_m, seen.y_m)) - ahead_m)
        )
        turn = math.atan2(y - seen.y_m, x - seen.x_m) - seen.yaw_rad
        angle = math.atan(2.0 * _WHEELBASE_M * math.sin(turn) / ahead_m)
        a = self._planner.acceleration_mps2
        return AckermannTarget(angle, 0.0, max(seen.speed_mps + 0.5 * a, 0.0), abs(a))


class _Referee:
    """Counts what happens, and ends the drive."""

    def __init__(self, world: Simulation, planner: BehaviourDriver):
        self._world, self._planner = world, planner
        self._speeds_mps: dict[int, float] = {}
        self._rows: list = []
        self._in_space: dict[int, tuple[float, float]] = {}
        self.result = Driven()

    def add(self, snapshot: Snapshot, command: Any, car: Any) -> bool:
        """Add a tick; return whether the drive is over."""
        state, result = snapshot.state, self.result
        result.collisions += len(snapshot.collisions)
        self._look_at_crossing(self._world.elapsed_s, snapshot)
        self._look_behind(state.x_m, state.y_m, snapshot)
        scene = self._planner.scene
        front = one_ahead(scene.own, scene.others, {scene.own.lane})
        gap = math.inf if front is None else gap_m(scene.own, front)
        row = (self._world.elapsed_s, state.x_m, state.speed_mps, gap, state.y_m)
        self._rows.append(row)
        over = state.x_m > FINISH_M or result.collisions > 0 or row[0] > LONGEST_S
        if over:
            result.rows = np.array(self._rows)
            result.taken = self._taken()
            if state.x_m > FINISH_M:
                result.mean_mps = (FINISH_M - START_M) / row[0]
        return over

    def _look_at_crossing(self, time_s: float, snapshot: Snapshot) -> None:
        """Note when the car, with number 1, and road users on the side road are in the space."""
        bodies = [(1, snapshot.state.x_m - SIDE_M)]
        bodies += [
            (obstacle.id, obstacle.y_m)
            for obstacle in snapshot.obstacles
            if obstacle.yaw_rad < -1.0
        ]
        for number, distance_m in bodies:
            if abs(distance_m) < SPACE_M:
                first_s, _ = self._in_space.get(number, (time_s, time_s))
                self._in_space[number] = first_s, time_s

    def _look_behind(self, x_m: float, y_m: float, snapshot: Snapshot) -> None:
        """Note how hard the vehicle behind the car, on the lane of the car, brakes."""
        behind = [
            obstacle
            for obstacle in snapshot.obstacles
            if obstacle.x_m < x_m and abs(obstacle.y_m - y_m) < 2.2
        ]
        if behind:
            nearest = max(behind, key=lambda vehicle: vehicle.x_m)
            braked_mps = self._speeds_mps.get(nearest.id, 0.0) - nearest.speed_mps
            self.result.pushed_mps2 = max(self.result.pushed_mps2, braked_mps / TICK_S)
        self._speeds_mps = {vehicle.id: vehicle.speed_mps for vehicle in snapshot.obstacles}

    def _taken(self) -> int:
        enters_s, leaves_s = self._in_space.pop(1, NEVER)
        return sum(
            last_s > enters_s and first_s < leaves_s + 1.0
            for first_s, last_s in self._in_space.values()
        )


def drive_scene(
    name: str,
    seed: int,
    chooses: Callable[[LaneScene], LaneProposal] = choose,
    **options: Any,
) -> Driven:
    """Drive one scene.

    Args:
        name: name of the scene, a key of SCENES
        seed: of the road users
        chooses: what chooses the manoeuvre
        options: how the driver decides, see BehaviourDriver
    """
    mission_m = np.array([(0.0, 0.0), (END_M, 0.0)])
    actors = SCENES[name](np.random.default_rng(seed))
    traffic = ScriptedTraffic(actors, mission_m, seed, TICK_S)
    vehicle = Vehicle(load_vehicle(config_path("vehicles/tesla_model3.yaml")))
    world = Simulation(vehicle, TICK_S, 0.5, start=(START_M, 0.0, 0.0), traffic=traffic)
    planner = BehaviourDriver(LaneRoad(crossing_road(), ROAD, LINES), chooses, **options)
    referee = _Referee(world, planner)
    drive(world, LabCar(planner), referee)  # type: ignore[arg-type]
    return referee.result


def main() -> None:
    """Print a line for each drive."""
    names = [word for word in sys.argv[1:] if word in SCENES] or [*SCENES]
    seeds = [int(word) for word in sys.argv[1:] if word.isdecimal()] or [1, 2, 3]
    for name in names:
        for seed in seeds:
            result = drive_scene(name, seed)
            counted = f"{result.collisions} collisions, right of way taken {result.taken} times"
            braked = f"others braked with {result.pushed_mps2:.1f} m/s2"
            print(f"{name} {seed}: {counted}, mean {result.mean_mps:.1f} m/s, {braked}", flush=True)


if __name__ == "__main__":
    main()
