"""The lanes of a map as shapes, for the map views and RViz, and as what a car can cross."""

from __future__ import annotations

from typing import Iterator

import numpy as np

from sdc_common.driving import other_level
from sdc_common.geometry.road_line import arc_lengths
from sdc_common.geometry.route import interpolate
from sdc_map.network import BROKEN, KERB, Network
from sdc_map.network_file import load_network
from sdc_sim.physics.collision import Rectangle
from sdc_sim.road import lane_invasion
from sdc_sim.road.road import DASH_LENGTH_M, DASH_PERIOD_M, MARGIN_M, Road
from sdc_sim.road.road_markings import RoadMarkings, road_markings

_KINDS = {BROKEN: lane_invasion.BROKEN, KERB: lane_invasion.OTHER}


def world_markings(route_m: np.ndarray, map_path: str) -> RoadMarkings:
    """Return the shapes of a map, or, where its path is empty, of the road along a route.

    Raises:
        ValueError: the points are no route, or the map cannot be read
    """
    return network_markings(load_network(map_path)) if map_path else road_markings(Road(route_m))


def network_markings(network: Network) -> RoadMarkings:
    """Return lines and asphalt of all lanes for cars, and stop lines."""
    edges: list[np.ndarray] = [ends[None] for ends, _ in network.stop_lines]
    dashes: list[np.ndarray] = []
    surface: list[np.ndarray] = []
    for line in network.lines():
        points = line.points_m
        if line.kind == BROKEN:
            s = arc_lengths(points)
            starts = np.arange(0.0, s[-1] - DASH_LENGTH_M, DASH_PERIOD_M)
            ends = [interpolate(s_m, s, points) for s_m in (starts, starts + DASH_LENGTH_M)]
            dashes.append(np.stack(ends, axis=1))
        else:
            edges.append(np.stack([points[:-1], points[1:]], axis=1))
    for lane in network.driving:
        right, left = (lane.beside(side * (0.5 * lane.width_m + MARGIN_M)) for side in (-1.0, 1.0))
        surface.append(np.stack([right[:-1], right[1:], left[1:], left[:-1]], axis=1))
    none = np.zeros((0, 2, 2))
    solid, broken = (np.concatenate([none, *parts]) for parts in (edges, dashes))
    return RoadMarkings(solid, broken, np.vstack(surface))


class NetworkInvasionDetector:
    """Compares the outline of the car with the lines of all lanes; see LaneInvasionDetector."""

    def __init__(self, network: Network):
        lines = network.lines()
        self._start = np.vstack([line.points_m[:-1] for line in lines])
        self._end = np.vstack([line.points_m[1:] for line in lines])
        self._z_m = np.concatenate([line.z_m[:-1] for line in lines])
        self._low = np.minimum(self._start, self._end)
        self._high = np.maximum(self._start, self._end)
        counts = [len(line.points_m) - 1 for line in lines]
        self._line = np.repeat(np.arange(len(lines)), counts)
        self._kinds = [_KINDS.get(line.kind, lane_invasion.SOLID) for line in lines]
        self.reset()

    def reset(self) -> None:
        """Forget the place of the car, which was moved."""
        self._first = True
        self._crossing: set[int] = set()

    def update(self, car: Rectangle) -> list[int]:
        """Return the kinds of the lines that the car has begun to cross since the last update."""
        on, near = (set(self._touched(car, far)) for far in (0.0, lane_invasion.CLEAR_M))
        begun = [] if self._first else sorted(on - self._crossing)
        self._first, self._crossing = False, on | (self._crossing & near)
        return [self._kinds[number] for number in begun]

    def _touched(self, car: Rectangle, beyond_m: float) -> Iterator[int]:
        """Return the lines on the outline of the car, widened to all sides."""
        centre, half = np.array([car.x_m, car.y_m]), np.array([car.length_m, car.width_m]) / 2
        reach = np.hypot(*half) + beyond_m
        near = (self._low < centre + reach) & (self._high > centre - reach)
        rows = np.flatnonzero(near.all(axis=1) & ~other_level(self._z_m, car.z_m))
        c, s = np.cos(car.yaw_rad), np.sin(car.yaw_rad)
        start, end = (
            (points[rows] - centre) @ np.array([[c, -s], [s, c]])
            for points in (self._start, self._end)
        )
        # Liang and Barsky, "A New Concept and Method for Line Clipping", ACM TOG 1984.
        step = np.where(np.abs(end - start) < 1e-9, 1e-9, end - start)
        right, left = ((side * (half + beyond_m) - start) / step for side in (-1.0, 1.0))
        enter = np.minimum(right, left).max(axis=1)
        leave = np.maximum(right, left).min(axis=1)
        yield from self._line[rows[(enter <= leave) & (enter <= 1.0) & (leave >= 0.0)]].tolist()


def of_map(map_path: str) -> NetworkInvasionDetector:
    """Return a detector for a map."""
    return NetworkInvasionDetector(load_network(map_path))
