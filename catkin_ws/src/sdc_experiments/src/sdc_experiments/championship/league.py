"""The drives of a league: conditions that a seed draws."""

from __future__ import annotations

import contextlib
import hashlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sdc_common.configuration import node_config
from sdc_common.geometry.segments import use_machine_code
from sdc_experiments.championship.mission import DriverMission
from sdc_experiments.configuration import planner_parameters
from sdc_experiments.recorder import stop_lines_of
from sdc_map.map_file import map_file
from sdc_sim.road.random_routes import long_route
from sdc_sim.scenario.drive_setup import DriveSetup, drive_setup
from sdc_sim.scenario.packaged import overridden
from sdc_sim.scenario.street_scenarios import of_map, types
from sdc_sim.simulation.simulation import Simulation

TABLE = node_config("sdc_experiments", "championship")
LEAGUES: dict[str, dict[str, Any]] = TABLE["leagues"]


@dataclass(frozen=True)
class Draw:
    """What a seed draws; equal arguments give an equal draw."""

    league: str  # a name of LEAGUES
    seed: str  # any text; public seeds are numbers
    route_m: np.ndarray | None = field(repr=False)  # (N, 2) waypoints, None on a map [m]
    sim: dict[str, Any]  # parameters that replace those of sdc_sim/config/sim.yaml
    planner: dict[str, Any]  # the same for the limits of our local planner
    map: str = ""  # path of the map, "" without one
    # Simulated time after which the drive is too late, None for the referee's [s]
    longest_s: float | None = None


def generator(league: str, seed: str, name: str) -> np.random.Generator:
    """Return the random numbers of one quantity, from which no other quantity can be computed."""
    digest = hashlib.sha256(f"{league}/{seed}/{name}".encode()).digest()
    return np.random.default_rng(int.from_bytes(digest, "big"))


def draw(league: str, seed: str) -> Draw:
    """Return what a seed draws."""
    row = LEAGUES[league]

    def drawn(ranges: dict[str, list]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for name, (low, high) in ranges.items():
            section, _, key = name.rpartition("/")
            inside = found.setdefault(section, {}) if section else found
            inside[key] = float(generator(league, seed, name).uniform(low, high))
        return found

    number = int(generator(league, seed, "noise").integers(2**31))
    sim = {**drawn(row["sim"]), "seed": number}
    if "map" not in row:
        route_m = long_route(generator(league, seed, "route"), **row["route"])
        return Draw(league, seed, route_m, sim, drawn(row["planner"]))
    path, random = map_file(row["map"], seed=number), generator(league, seed, "type")
    while True:
        name = sorted(types())[int(random.integers(len(types())))]
        with contextlib.suppress(ValueError):  # A random town has no place for some types.
            limit_s = of_map(path, name, number).limit_s
            return Draw(league, seed, None, {**sim, "street_scenario": name}, {}, path, limit_s)


def prepared(drawn: Draw) -> tuple[DriveSetup, Simulation, DriverMission]:
    """Return the conditions of a drive, its world at the start, and what its driver gets."""
    use_machine_code()
    setup = drive_setup("", drawn.route_m, drawn.sim, drawn.map)
    missions = setup.missions
    world = setup.simulation(compiled=True)
    limits = overridden(planner_parameters(missions is not None), drawn.planner, "planner")
    lines, seen = stop_lines_of(world.lights), world.observation
    goals = () if missions is None else tuple(missions.goals)
    mission = DriverMission(drawn.league, setup.waypoints_m, seen, limits, lines, drawn.map, goals)
    return setup, world, mission
