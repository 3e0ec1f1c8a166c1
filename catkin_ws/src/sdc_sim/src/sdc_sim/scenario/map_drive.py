"""Drives on a map: where they begin and end."""

from __future__ import annotations

import importlib
from typing import Mapping, Sequence

import numpy as np

from sdc_map.lane_graph import LaneGraph, drawn_places
from sdc_map.mission import Mission, Point, plan_mission


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


def given_points(name: str, arguments: Mapping[str, str]) -> list[Point]:
    """Return the points of an argument, such as X,Y;X,Y [m]; ValueError if it is not valid."""
    text = arguments.get(name, "")
    try:
        numbers = [[float(word) for word in part.split(",")] for part in text.split(";") if text]
    except ValueError:
        numbers = [[]]
    if any(len(point) != 2 for point in numbers) or not np.isfinite(numbers).all():
        raise ValueError(f"{name}:={text}: must be X,Y [m]")
    return list(numbers)
