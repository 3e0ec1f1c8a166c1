"""Read the traffic of a scenario: its obstacles and traffic lights, which the simulator needs."""

from __future__ import annotations

import importlib
import math

import numpy as np

from sdc_common.geometry.route import Route
from sdc_sim.physics.obstacles import KINDS, ObstaclePlan
from sdc_sim.physics.traffic_lights import TrafficLightPlan
from sdc_sim.yaml_document import YamlDocument, load_document

# Shorter segments of an obstacle's path have no direction.
_MIN_SEGMENT_M = 1e-3
# An obstacle on a lane drives about so far.
_WAY_M = 1000.0


def load_traffic(
    path: str, route: Route, map_path: str = ""
) -> tuple[list[ObstaclePlan], list[TrafficLightPlan]]:
    """Read the obstacles and traffic lights of a scenario; an empty path has none.

    A point is [x, y] with `frame: map`, and [distance along the route, distance to its left] with
    `frame: route`. Lanes are those of the map.

    Raises:
        DocumentError: the file is not valid, or a point or a stop line is not on the route.
    """
    if not path:
        return [], []
    document = read_scenario(path)
    obstacles = [
        _obstacle(document, ("obstacles", index), entry, route, map_path)
        for index, entry in enumerate(document.values.get("obstacles", ()))
    ]
    lights = []
    for index, entry in enumerate(document.values.get("lights", ())):
        keys = ("lights", index, "stop_line_m")
        x, y, heading = _on_route(document, keys, entry["stop_line_m"], route)
        phases = tuple(item for phase in entry["phases"] for item in phase.items())
        lights.append(TrafficLightPlan(x, y, heading, phases, entry.get("offset_s", 0.0)))
    return obstacles, lights


def read_scenario(path: str) -> YamlDocument:
    """Return a file that is valid by config/schemas/scenario.yaml.

    Raises:
        DocumentError: the file cannot be read or is not valid
    """
    fix = "name a readable YAML file (scenario:=, obstacles_path:=)"
    return load_document(path, "scenario", fix)


def _obstacle(
    document: YamlDocument, keys: tuple, entry: dict, route: Route, map_path: str
) -> ObstaclePlan:
    length, width, height = entry.get("size_m", KINDS[entry["kind"]].size_m)
    size = (length, width, height)
    if "at" in entry:
        point, heading = _place(document, (*keys, "at"), entry["at"], route)
        return ObstaclePlan(entry["kind"], (point,), size, heading + entry.get("yaw_rad", 0.0))
    timing = {key: entry[key] for key in ("speed_mps", "start_s", "trigger_m") if key in entry}
    if "lane" in entry:
        points, heading = _along_lanes(document, keys, entry, map_path)
        shown = points if timing else points[:1]
        return ObstaclePlan(entry["kind"], tuple(shown), size, heading, **timing)
    points = []
    for index, place in enumerate(entry["path"]):
        point, _ = _place(document, (*keys, "path", index), place, route)
        if points and math.dist(points[-1], point) < _MIN_SEGMENT_M:
            raise document.error(
                (*keys, "path", index), "'path' repeats the previous point; remove one of them"
            )
        points.append(point)
    return ObstaclePlan(entry["kind"], tuple(points), size, **timing)


def _along_lanes(
    document: YamlDocument, keys: tuple, entry: dict, map_path: str
) -> tuple[list[tuple[float, float]], float]:
    """Return points from a place on a lane straight on, and the heading there [rad]."""
    if not map_path:
        raise document.error((*keys, "lane"), "a lane needs streets; add 'map'")
    network = importlib.import_module("sdc_map.network_file").load_network(map_path)
    name, at_m = entry["lane"], entry["at_m"]
    if name not in network.lanes:
        fix = f"python3 -m sdc_map.network_file {map_path} --lanes prints them"
        raise document.error((*keys, "lane"), f"{name} is no lane of the map; {fix}")
    lane = network.lanes[name]
    if at_m > lane.length_m:
        fix = f"the lane ends at {lane.length_m:.1f} m; give a place on it"
        raise document.error((*keys, "at_m"), fix)
    heading = lane.heading_at(at_m)
    points = [*lane.at(np.array([at_m])), *lane.points_m[lane.s_m > at_m]]
    length_m = 0.0
    while (lane := network.straight_on(lane)) and length_m < _WAY_M:
        length_m += lane.length_m
        points += list(lane.points_m[1:])
    return [(float(x), float(y)) for x, y in points], heading


def _place(
    document: YamlDocument, keys: tuple, place: list, route: Route
) -> tuple[tuple[float, float], float]:
    """Return a point (x, y) in the map [m], and the heading that yaw_rad is added to [rad]."""
    first, second = place
    if document.values["frame"] == "map":
        return (first, second), 0.0
    x, y, heading = _on_route(document, keys, first, route)
    return (x - second * math.sin(heading), y + second * math.cos(heading)), heading


def _on_route(
    document: YamlDocument, keys: tuple, along_m: float, route: Route
) -> tuple[float, float, float]:
    """Return x, y [m] and the heading [rad] of the route at a distance along it [m]."""
    if not 0.0 <= along_m <= route.length_m:
        raise document.error(
            keys,
            f"the place is {along_m:g} m along a route of {route.length_m:.1f} m; "
            f"give a distance from 0 to {route.length_m:.1f}",
        )
    x, y, heading = (
        float(np.interp(along_m, route.s, values)) for values in (*route.points.T, route.heading)
    )
    return x, y, heading
