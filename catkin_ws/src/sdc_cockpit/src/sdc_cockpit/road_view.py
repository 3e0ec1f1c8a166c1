"""The road and the route as the page draws them."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from sdc_common.geometry.route import Route
from sdc_sim.road.road import Road
from sdc_sim.road.road_markings import road_markings

_DECIMALS = 2


class RoadView:
    """The road of one route.

    Args:
        route_m: (N, 2) points of the route [m]

    Raises:
        ValueError: the points are no route
    """

    def __init__(self, route_m: np.ndarray):
        self._route = Route(route_m)
        self._json: bytes | None = None

    def cross_track_m(self, x_m: float, y_m: float, yaw_rad: float) -> float:
        """Return the distance from the route, positive to its left [m]."""
        return self._route.locate(x_m, y_m, yaw_rad).cross_track_m

    def to_json(self) -> bytes:
        """Return route and road as JSON; the first call computes it."""
        if self._json is None:
            markings = road_markings(Road(self._route.points))
            self._json = json.dumps(
                {
                    "route": _rounded(self._route.points),
                    "edges": _rounded(markings.edges),
                    "dashes": _rounded(markings.dashes),
                    "surface": _rounded(markings.surface),
                },
                separators=(",", ":"),
            ).encode()
        return self._json


def _rounded(points: np.ndarray) -> list[Any]:
    """Return the numbers as a flat list."""
    return np.round(np.asarray(points, dtype=float), _DECIMALS).ravel().tolist()
