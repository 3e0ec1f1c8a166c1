"""Roads that are drawn, such as that of the second graded drive, with traffic.

All students of a class drive the same road, and none has seen it before. A light is red when the
car arrives, a pedestrian crosses in front of it, and a slow car drives ahead and turns off.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from sdc_sim.road.random_routes import long_route
from sdc_sim.road.route_generator import csv_lines, generate_route

SPACING_M = 1.0
_FIRST_M = 75.0  # straight with the light, which the car reaches before it is green
_STRAIGHT_M = 85.0
_UNSEEN_M = 200.0
_SIDES = ("right_deg", "left_deg")


def write_unknown_route(seed: int, folder: Path) -> tuple[Path, Path]:
    """Write the road and its traffic, and return the waypoint file and the scenario file."""
    random = np.random.default_rng(seed)
    elements: list = [{"straight_m": _FIRST_M}]
    line_m = round(_FIRST_M - random.uniform(12.0, 25.0), 1)
    red_s = round(random.uniform(20.0, 24.0), 1)
    side = int(random.integers(2))
    length_m, obstacles = _FIRST_M, []
    for kind in random.permutation(["pedestrian", "car"]):
        # A bend to the other side each time: the road does not cross itself.
        side = 1 - side
        angle_deg, radius_m = random.uniform(40.0, 80.0), random.uniform(14.0, 30.0)
        bend = {_SIDES[side]: angle_deg, "radius_m": radius_m, "transition_m": 6.0}
        elements += [bend, {"straight_m": _STRAIGHT_M}]
        start_m = length_m + np.radians(angle_deg) * radius_m + 6.0
        obstacles.append(_OBSTACLES[kind](random, start_m, 2.0 * side - 1.0))
        length_m = start_m + _STRAIGHT_M
    start = {"x_m": 0.0, "y_m": 0.0, "heading_deg": float(random.uniform(-180.0, 180.0))}
    rows = generate_route({"elements": elements, "start": start, "spacing_m": SPACING_M})
    lights = [{"stop_line_m": line_m, "phases": [{"red": red_s}, {"green": 600.0}]}]
    route, scenario = folder / "unknown_route.csv", folder / "unknown_route.yaml"
    route.write_text("".join(csv_lines(rows)), encoding="utf-8")
    text = yaml.safe_dump({"frame": "route", "obstacles": obstacles, "lights": lights})
    scenario.write_text(text, encoding="utf-8")
    return route, scenario


def write_unseen_road(seed: int, folder: Path) -> tuple[Path]:
    """Write a road without traffic, for a car that drives by its camera alone; return the file."""
    route = folder / "unknown_route.csv"
    # The y axis of a waypoint file points to the right.
    np.savetxt(route, long_route(seed, _UNSEEN_M) * (1.0, -1.0), fmt="%.4f", delimiter=",")
    return (route,)


def _pedestrian(random: np.random.Generator, start_m: float, side: float) -> dict:
    """Return a person who walks so slowly that a car at any usual speed meets them."""
    at_m, from_m = start_m + random.uniform(45.0, 55.0), random.choice([-1.0, 1.0]) * 4.0
    path = [[float(at_m), float(from_m)], [float(at_m), float(-1.5 * from_m)]]
    speed_mps = float(random.uniform(0.85, 0.95))
    return {"kind": "pedestrian", "path": path, "speed_mps": speed_mps, "trigger_m": 42.0}


def _slow_car(random: np.random.Generator, start_m: float, side: float) -> dict:
    """Return a car that turns off to the outer side of the bend behind it."""
    at_m, for_m = start_m + random.uniform(4.0, 10.0), random.uniform(35.0, 42.0)
    places = ((0.0, 0.0), (for_m, 0.0), (for_m + 15.0, 8.0), (for_m + 30.0, 16.0))
    path = [[float(at_m + along_m), side * left_m] for along_m, left_m in places]
    speed_mps = float(random.uniform(3.0, 4.0))
    return {"kind": "car", "path": path, "speed_mps": speed_mps, "trigger_m": 30.0}


_OBSTACLES = {"pedestrian": _pedestrian, "car": _slow_car}
