"""The road and the route as the page draws them."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from sdc_common.geometry.route import Route
from sdc_sim.road.network_markings import world_markings

_DECIMALS = 2
# The stretch of the route around the last place in which the car is expected [m].
_BACK_M, _AHEAD_M = 3.0, 10.0
# A car that is farther from this stretch was placed elsewhere [m].
_LOST_M = 4.0


class RoadView:
    """The road of one route, or the streets of a map.

    Raises:
        ValueError: the points are no route
    """

    def __init__(self, route_m: np.ndarray, map_path: str = ""):
        self._map_path = map_path
        self._route = Route(route_m)
        self._last_s_m: float | None = None
        self._json: bytes | None = None

    def cross_track_m(self, x_m: float, y_m: float, yaw_rad: float) -> float:
        """Return the distance from the route, positive to its left [m].

        The search starts at the last place: where the route crosses itself, another pass is near.
        """
        place = None
        if self._last_s_m is not None:
            place = self._route.line.project(x_m, y_m, self._last_s_m, _BACK_M, _AHEAD_M)
        if place is None or place.distance_m > _LOST_M:
            place = self._route.locate(x_m, y_m, yaw_rad)
        self._last_s_m = place.s_m
        return place.cross_track_m

    @property
    def progress(self) -> float:
        """Return the share of the route up to the last place of the car."""
        return (self._last_s_m or 0.0) / self._route.length_m

    def to_json(self) -> bytes:
        """Return route and road as JSON; the first call computes it."""
        if self._json is None:
            markings = world_markings(self._route.points, self._map_path)
            shapes = {"route": self._route.points, **vars(markings)}
            flat = {name: _rounded(points) for name, points in shapes.items()}
            self._json = json.dumps(flat, separators=(",", ":")).encode()
        return self._json


def _rounded(points: np.ndarray) -> list[Any]:
    """Return the numbers as a flat list."""
    return np.round(np.asarray(points, dtype=float), _DECIMALS).ravel().tolist()
