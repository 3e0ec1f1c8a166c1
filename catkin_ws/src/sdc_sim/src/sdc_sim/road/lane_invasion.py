"""Tells when the car begins to cross a line of the road."""

from __future__ import annotations

import math

from sdc_common.geometry.route import Route
from sdc_sim.physics.collision import Rectangle
from sdc_sim.road.road import Road

# As carla_msgs/CarlaLaneInvasionEvent numbers them.
OTHER, BROKEN, SOLID = 0, 1, 2

# A line that the car has crossed counts again when the whole car has been this far off it.
_CLEAR_M = 0.1
_BACK_M, _AHEAD_M = 10.0, 15.0
# By how much a corner of the car may lie farther aside in the tightest bend than on a straight road.
_BEND_M = 0.35


class LaneInvasionDetector:
    """Watches the outline of the car against the three lines of the road: right edge, centre, left edge.

    The car's place is sought near its last one, so that the lines of another pass of the road, which it drives over at a
    crossing, do not count; a car that has left the road is sought anew everywhere.
    """

    def __init__(self, road: Road):
        self._lines = (
            (road.right_edge_m, SOLID),
            (road.centre_line_m, BROKEN),
            (road.left_edge_m, SOLID),
        )
        self._lost_m = 2.5 * road.lane_width_m
        self._route = Route(road.points_m)
        self._s_m = None
        self._crossing = set()

    def update(self, car: Rectangle) -> list:
        """The kinds of the lines that the car has begun to cross since the last update; none in the first one."""
        first = self._s_m is None
        place = (
            None if first else self._route.project(car.x_m, car.y_m, self._s_m, _BACK_M, _AHEAD_M)
        )
        if first or place.distance_m > self._lost_m:
            place = self._route.locate(car.x_m, car.y_m, car.yaw_rad)
        self._s_m = place.s_m
        turn = car.yaw_rad - place.heading_rad
        reach = (
            0.5 * (car.length_m * abs(math.sin(turn)) + car.width_m * abs(math.cos(turn)))
            + _BEND_M
            + _CLEAR_M
        )
        if (
            self._lines[0][0] < place.cross_track_m - reach
            and place.cross_track_m + reach < self._lines[1][0]
        ):
            self._crossing = set()  # well within the lane: no need to look at each corner
            return []
        lateral = [
            self._route.project(x, y, place.s_m, _BACK_M, _AHEAD_M).cross_track_m
            for x, y in car.corners()
        ]
        right, left = min(lateral), max(lateral)
        on = {number for number, (at, _) in enumerate(self._lines) if right < at < left}
        near = {
            number
            for number, (at, _) in enumerate(self._lines)
            if right - _CLEAR_M < at < left + _CLEAR_M
        }
        begun = sorted(on - self._crossing)
        self._crossing = on | (self._crossing & near)
        return [] if first else [self._lines[number][1] for number in begun]

    def reset(self) -> None:
        """The car has been put somewhere else."""
        self._s_m = None
        self._crossing = set()
