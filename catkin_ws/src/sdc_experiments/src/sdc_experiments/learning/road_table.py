"""Several routes as arrays, to find the places of many cars at once."""

from __future__ import annotations

from typing import NamedTuple, Sequence

import numpy as np

from sdc_common.geometry.route import Route
from sdc_experiments.learning.observation import longest_s, road_rows

# A car moves by less than a segment in a tick, or by less than three on fine waypoints.
_SEGMENTS_BACK, _SEGMENTS_AHEAD = 2, 3


class RoadPlaces(NamedTuple):
    """The places of N cars on their routes, (N,) each.

    Attributes:
        segment: row of the segment in the table
        s_m: arc length [m]
        cross_track_m: distance of the car, positive left of the route [m]
        heading_rad: heading of the route, not wrapped [rad]
    """

    segment: np.ndarray
    s_m: np.ndarray
    cross_track_m: np.ndarray
    heading_rad: np.ndarray


class RoadTable:
    """The segments of several routes, one after the other.

    Attributes:
        first: (K,) row of the first segment of each route
        last: (K,) row of its last segment
        length_m: (K,) length [m]
        longest_s: (K,) time after which a drive is truncated [s]
        start: (K, 3) x, y [m] and direction [rad] of its start
        ahead: (metres of all routes, 2 * places) rows of road_rows
        first_row: (K,) row of the first metre of each route
    """

    def __init__(self, routes: Sequence[Route]):
        counts = np.array([len(route.points) - 1 for route in routes])
        self.last = np.cumsum(counts) - 1
        self.first = self.last - counts + 1
        points = [route.points for route in routes]
        steps = [np.diff(one, axis=0) for one in points]
        self._lengths = np.concatenate([np.hypot(*step.T) for step in steps])
        directions = np.vstack(steps) / self._lengths[:, None]
        self._x, self._y = np.vstack([one[:-1] for one in points]).T
        self._direction_x, self._direction_y = directions.T
        self._s = np.concatenate([route.s[:-1] for route in routes])
        self._heading = np.concatenate([route.heading[:-1] for route in routes])
        self._turn = np.concatenate([np.diff(route.heading) for route in routes])
        self.length_m = np.array([route.length_m for route in routes])
        self.longest_s = np.array([longest_s(route) for route in routes])
        headings = np.arctan2(self._direction_y[self.first], self._direction_x[self.first])
        self.start = np.column_stack([self._x[self.first], self._y[self.first], headings])
        rows = [road_rows(route) for route in routes]
        self.ahead = np.vstack(rows)
        self.first_row = np.append(0, np.cumsum([len(one) for one in rows]))[:-1]

    def starts(self, roads: np.ndarray) -> RoadPlaces:
        """Return the places at the starts of some routes."""
        first, zeros = self.first[roads], np.zeros(len(roads))
        return RoadPlaces(first, zeros, zeros.copy(), self._heading[first])

    def places(
        self, roads: np.ndarray, near: np.ndarray, x_m: np.ndarray, y_m: np.ndarray
    ) -> RoadPlaces:
        """Return the places of cars near their last segments.

        Args:
            roads: (N,) index of the route of each car
            near: (N,) row of the last segment of each car
            x_m: (N,) positions [m]
            y_m: (N,) positions [m]
        """
        first, last = self.first[roads], self.last[roads]
        best = np.full(len(roads), np.inf)
        segment, along, side = near.copy(), np.zeros(len(roads)), np.zeros(len(roads))
        for shift in range(-_SEGMENTS_BACK, _SEGMENTS_AHEAD + 1):
            row = np.minimum(np.maximum(near + shift, first), last)
            offset_x, offset_y = x_m - self._x[row], y_m - self._y[row]
            direction_x, direction_y = self._direction_x[row], self._direction_y[row]
            position = offset_x * direction_x + offset_y * direction_y
            position = np.minimum(np.maximum(position, 0.0), self._lengths[row])
            away_x, away_y = offset_x - position * direction_x, offset_y - position * direction_y
            square = away_x * away_x + away_y * away_y
            nearer = square < best
            np.copyto(best, square, where=nearer)
            np.copyto(segment, row, where=nearer)
            np.copyto(along, position, where=nearer)
            np.copyto(side, direction_x * away_y - direction_y * away_x, where=nearer)
        heading = self._heading[segment] + along / self._lengths[segment] * self._turn[segment]
        cross_track = np.copysign(np.sqrt(best), side)
        return RoadPlaces(segment, self._s[segment] + along, cross_track, heading)

    def rows_ahead(self, roads: np.ndarray, s_m: np.ndarray) -> np.ndarray:
        """Return what cars at these places see of the road: (N, 2 * places)."""
        return self.ahead[self.first_row[roads] + np.rint(s_m).astype(int)]
