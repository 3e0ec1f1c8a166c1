"""Drives on a map: where they begin and end."""

from __future__ import annotations

import importlib
import os
from typing import Mapping, Sequence

import numpy as np

from sdc_map.lane_graph import LaneGraph, drawn_places
from sdc_map.map_file import map_file
from sdc_map.mission import Mission, Point, plan_mission
from sdc_map.network_file import load_network
from sdc_sim.scenario.packaged import options_text, parse_options


def first_mission(
    graph: LaneGraph,
    start: Point | None,
    goals: Sequence[Point],
    seed: int,
    street_scenario: str = "",
) -> tuple[Mission, Sequence[Point]]:
    """Return the mission from a start to goals, and the goals; what is not given is drawn.

    Raises:
        NoRouteError: a goal cannot be reached
        ValueError: the scenario type has its own start and goal, is unknown, or has no place
    """
    if street_scenario:
        if start or goals:
            text = "has its own start and goal; remove start and goal"
            raise ValueError(f"street_scenario: {street_scenario} {text}")
        types = importlib.import_module("sdc_sim.scenario.street_scenarios")
        placed = types.place(street_scenario, graph.network, seed)
        start, goals = placed.start, placed.goals
    if not (start and goals):
        begin, end = drawn_places(graph, seed, start)
        start, goals = start or begin, goals or [end]
    return plan_mission(graph, goals, start[0], start[1]), goals


def file_points(points_m: np.ndarray) -> np.ndarray:
    """Return points (N, 2) as they are after they were written to the file of ./drive [m]."""
    return np.array([[float(f"{x:.6f}"), float(f"{y:.6f}")] for x, y in points_m.tolist()])


def launch_arguments(report: str, given: dict[str, str]) -> dict[str, str]:
    """Write the first mission on a map beside the report; return the arguments of all.launch.

    Raises:
        ValueError: an argument is not valid, or a goal cannot be reached
    """
    options = parse_options(given.get("sim_options") or "{}")
    for name in ("seed", "traffic"):
        if not given.get(name):
            continue
        number = int(given[name]) if given[name].isdecimal() else -1
        if options.setdefault(name, number) != number or number < 0:
            text = f"must be a number of at least 0, and no other than the {name} in sim_options"
            raise ValueError(f"{name}:={given[name]}: {text}")
    given = {**given, "sim_options": options_text(options)}
    if not given.get("map"):
        return given
    seed = options.get("seed", 0)
    streets = map_file(given["map"], seed=seed)
    graph = LaneGraph(load_network(streets))
    start, wanted = given_points("start", given), given_points("goal", given)
    begin = start[0] if start else None
    name = options.get("street_scenario", "")
    mission, goals = first_mission(graph, begin, wanted, seed, name)
    path = os.path.splitext(os.path.abspath(report))[0] + ".route.csv"
    os.makedirs(os.path.dirname(path), exist_ok=True)
    # The y axis of a waypoint file points to the right.
    np.savetxt(path, mission.points_m * (1.0, -1.0), fmt="%.6f", delimiter=",")
    return {
        **given,
        "waypoints_path": path,
        "map": streets,
        "goal": str([list(map(float, goal)) for goal in goals]),
    }


def given_points(name: str, given: Mapping[str, str]) -> list[Point]:
    """Return the points of an argument, such as X,Y;X,Y [m]; ValueError if it is not valid."""
    text = given.get(name, "")
    try:
        numbers = [[float(one) for one in part.split(",")] for part in text.split(";") if text]
    except ValueError:
        numbers = [[]]
    if any(len(point) != 2 for point in numbers) or not np.isfinite(numbers).all():
        raise ValueError(f"{name}:={text}: must be X,Y [m]")
    return list(numbers)
