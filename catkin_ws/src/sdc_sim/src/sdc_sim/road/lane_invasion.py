"""Detects when the car begins to cross a line of the road."""

from __future__ import annotations

from sdc_common.geometry.polyline import Place
from sdc_common.geometry.route import Route
from sdc_sim.physics.collision import Rectangle
from sdc_sim.physics.traffic_lights import LANE_WIDTH_M

# As carla_msgs/CarlaLaneInvasionEvent numbers them.
OTHER, BROKEN, SOLID = 0, 1, 2

# Lateral offsets from the route, the middle of the right lane, and kinds of the lines.
_LINES = ((-0.5 * LANE_WIDTH_M, SOLID), (0.5 * LANE_WIDTH_M, BROKEN), (1.5 * LANE_WIDTH_M, SOLID))
_LOST_M = 2.5 * LANE_WIDTH_M
# A crossed line counts again after the whole car was this far off it.
CLEAR_M = 0.1
_BACK_M, _AHEAD_M = 10.0, 15.0


class LaneInvasionDetector:
    """Compares the outline of the car with the right edge, centre and left edge of the road.

    The car's place is searched near the last one, so that the lines of another pass do not count
    where the road crosses itself. A car that has left the road is searched on the whole road.
    """

    def __init__(self, route: Route):
        self._route = route
        self._s_m: float | None = None
        self._crossing: set[int] = set()

    def update(self, car: Rectangle) -> list[int]:
        """Return the kinds of the lines that the car has begun to cross since the last update.

        The first update after the start or a reset returns none.
        """
        first = self._s_m is None
        place = self._locate(car)
        self._s_m = place.s_m
        lateral = [
            self._route.line.project(x, y, place.s_m, _BACK_M, _AHEAD_M).cross_track_m
            for x, y in car.corners()
        ]
        right, left = min(lateral), max(lateral)
        on, near = (
            {number for number, (y_m, _) in enumerate(_LINES) if right - far < y_m < left + far}
            for far in (0.0, CLEAR_M)
        )
        begun = sorted(on - self._crossing)
        self._crossing = on | (self._crossing & near)
        return [] if first else [_LINES[number][1] for number in begun]

    def reset(self) -> None:
        """Forget the place of the car, which was moved."""
        self._s_m = None
        self._crossing = set()

    def _locate(self, car: Rectangle) -> Place:
        if self._s_m is not None:
            place = self._route.line.project(car.x_m, car.y_m, self._s_m, _BACK_M, _AHEAD_M)
            if place.distance_m <= _LOST_M:
                return place
        return self._route.locate(car.x_m, car.y_m, car.yaw_rad)
