"""Several routes as arrays, to find the places of many cars at once."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from sdc_common.geometry.route import Route
from sdc_experiments.learning.observation import longest_s, road_rows

# A car moves by less than a segment in a tick, or by less than three on fine waypoints.
_SEGMENTS_BACK, _SEGMENTS_AHEAD = 2, 3
# Rows of the segments, and of the places of cars.
_X, _Y, _DIRECTION_X, _DIRECTION_Y, _LENGTH, _S, _HEADING, _TURN = range(8)
SEGMENT, S, CROSS_TRACK, HEADING = range(4)


class RoadTable:
    """The segments of several routes, one after the other.

    Attributes:
        segments: (8, segments) start x, y, direction x, y, length, arc length, heading, turn
        ends: (K, 2) columns of the first and the last segment of each route
        length_m: (K,) length [m]
        longest_s: (K,) time after which a drive is truncated [s]
        start: (K, 3) x, y [m] and direction [rad] of its start
        ahead: (metres of all routes, 2 * places) rows of road_rows
        first_row: (K,) row of the first metre of each route
    """

    def __init__(self, routes: Sequence[Route]):
        counts = np.array([len(route.points) - 1 for route in routes])
        last = np.cumsum(counts) - 1
        self.ends = np.column_stack([last - counts + 1, last])
        points = [route.points for route in routes]
        steps = np.vstack([np.diff(line, axis=0) for line in points])
        lengths = np.hypot(*steps.T)
        self.segments = np.vstack(
            [
                *np.vstack([line[:-1] for line in points]).T,
                *(steps / lengths[:, None]).T,
                lengths,
                np.concatenate([route.s[:-1] for route in routes]),
                np.concatenate([route.heading[:-1] for route in routes]),
                np.concatenate([np.diff(route.heading) for route in routes]),
            ]
        )
        self.length_m = np.array([route.length_m for route in routes])
        self.longest_s = np.array([longest_s(route) for route in routes])
        x, y, direction_x, direction_y, *_ = self.segments[:, self.ends[:, 0]]
        self.start = np.column_stack([x, y, np.arctan2(direction_y, direction_x)])
        rows = [road_rows(route) for route in routes]
        self.ahead = np.vstack(rows)
        self.first_row = np.append(0, np.cumsum([len(part) for part in rows]))[:-1]

    def starts(self, roads: np.ndarray) -> np.ndarray:
        """Return the places (4, N) at the starts of some routes; see find_places."""
        first, zeros = self.ends[roads, 0], np.zeros(len(roads))
        return np.vstack([first, zeros, zeros, self.segments[_HEADING, first]])

    def rows_ahead(self, roads: np.ndarray, s_m: np.ndarray) -> np.ndarray:
        """Return what cars at these places see of the road: (N, 2 * places)."""
        return self.ahead[self.first_row[roads] + np.rint(s_m).astype(int)]


def find_places(
    segments: np.ndarray,
    ends: np.ndarray,
    roads: np.ndarray,
    positions_m: tuple[np.ndarray, np.ndarray],
    near: np.ndarray,
    places: np.ndarray,
    first_car: int,
    last_car: int,
) -> None:
    """Find the places of some cars near their last ones. Numba can compile it.

    Args:
        segments: those of a RoadTable
        ends: those of a RoadTable
        roads: (N,) index of the route of each car
        positions_m: x (N,) and y (N,) of each car [m]
        near: (4, N) last places
        places: (4, N) receives the places: column of the segment, arc length [m], distance
            of the car, positive left of the route [m], heading of the route, not wrapped [rad]
        first_car: first car to find
        last_car: the car after the last one to find
    """
    x_m, y_m = positions_m
    for car in range(first_car, last_car):
        road = roads[car]
        last_segment = int(near[SEGMENT, car])
        best, segment, along, side = math.inf, last_segment, 0.0, 0.0
        for shift in range(-_SEGMENTS_BACK, _SEGMENTS_AHEAD + 1):
            row = min(max(last_segment + shift, ends[road, 0]), ends[road, 1])
            offset_x, offset_y = x_m[car] - segments[_X, row], y_m[car] - segments[_Y, row]
            direction_x, direction_y = segments[_DIRECTION_X, row], segments[_DIRECTION_Y, row]
            position = offset_x * direction_x + offset_y * direction_y
            position = min(max(position, 0.0), segments[_LENGTH, row])
            away_x, away_y = offset_x - position * direction_x, offset_y - position * direction_y
            square = away_x * away_x + away_y * away_y
            if square < best:
                best, segment, along = square, row, position
                side = direction_x * away_y - direction_y * away_x
        turned = along / segments[_LENGTH, segment] * segments[_TURN, segment]
        places[SEGMENT, car] = segment
        places[S, car] = segments[_S, segment] + along
        places[CROSS_TRACK, car] = math.copysign(math.sqrt(best), side)
        places[HEADING, car] = segments[_HEADING, segment] + turned
