"""A two-lane road along a route: its lanes, lines, edges and dashes.

All geometry is in the ROS map frame (x forward, y left, metres). The route is the centre of the
right-hand lane. With lane width `w` and lateral offsets positive to the left of the route:

    -w/2  right solid edge    +w/2  dashed centre line    +3w/2  left solid edge
"""

from __future__ import annotations

import numpy as np

from sdc_common.geometry.segment_index import SegmentIndex
from sdc_sim.road.centre_line import SAMPLE_STEP_M, CentreLine
from sdc_sim.road.scenery import Scenery, generate_scenery

LINE_WIDTH_M = 0.15
DASH_LENGTH_M = 3.0
DASH_PERIOD_M = 9.0
MARGIN_M = 0.35  # asphalt outside the solid lines
# Between the straight pieces that are drawn and the computed road, at the outer edge.
CHORD_TOLERANCE_M = 0.003
# Points farther from the route than this count as off the road.
_MIN_REACH_M = 10.0


class Road(CentreLine):
    """The road along a route; see CentreLine for its samples.

    Attributes:
        lane_width_m: width of a lane [m]
        right_edge_m: lateral offset of the right solid line [m]
        centre_line_m: lateral offset of the dashed line [m]
        left_edge_m: lateral offset of the left solid line [m]
    """

    def __init__(self, route_m: np.ndarray, lane_width_m: float = 3.5):
        """Build the road.

        Args:
            route_m: (N, 2) waypoints, N >= 2, in the map frame [m]
            lane_width_m: width of a lane [m]

        Raises:
            ValueError: CentreLine refuses the route, or the lane width is not positive
        """
        if not (np.isfinite(lane_width_m) and lane_width_m > 0):
            raise ValueError(f"lane_width_m must be positive, got {lane_width_m}")
        self.lane_width_m = float(lane_width_m)
        self.right_edge_m = -0.5 * self.lane_width_m
        self.centre_line_m = 0.5 * self.lane_width_m
        self.left_edge_m = 1.5 * self.lane_width_m
        super().__init__(route_m, self.lane_width_m)
        own = np.flatnonzero(~(self.repeats[:-1] & self.repeats[1:]))
        reach_m = max(_MIN_REACH_M, 2.0 * self.lane_width_m)
        self._segments = SegmentIndex(self.points_m[own], self.points_m[own + 1], reach_m)

    def scenery(self, seed: int = 0) -> Scenery:
        """Return trees and buildings next to the road, the same for the same road and seed."""
        right_m, left_m = self.right_edge_m - MARGIN_M, self.left_edge_m + MARGIN_M
        return generate_scenery(self, right_m, left_m, self.on_road, seed)

    def stations(
        self, tolerance_m: float = CHORD_TOLERANCE_M, longest_m: float = 8.0
    ) -> np.ndarray:
        """Return the indices of samples between which the road, edges included, is straight.

        Args:
            tolerance_m: largest distance between the road and a straight piece of it [m]
            longest_m: longest distance between two stations [m]
        """
        return self.stations_within(self.left_edge_m + 1.0, tolerance_m, longest_m)

    def lane_points(
        self,
        offset_m: float,
        start_m: float = 0.0,
        end_m: float | None = None,
        step_m: float = SAMPLE_STEP_M,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return points on a line parallel to the route, and which of them are visible.

        A point is hidden where the line folds over itself inside a tight turn, or where another
        pass of the road covers it.

        Args:
            offset_m: lateral offset of the line, positive to the left [m]
            start_m: arc length of the first point [m]
            end_m: arc length of the end of the line, None for the end of the route [m]
            step_m: distance between the points along the route [m]

        Returns:
            points (N, 2) [m] and the mask (N,) of the visible ones
        """
        end_m = self.length_m if end_m is None else end_m
        s = start_m + step_m * np.arange(max(1, int((end_m - start_m) / step_m + 1e-9) + 1))
        points, left = self.at(s)
        points = points + offset_m * left
        visible = np.abs(self.lateral_m(points)) > abs(offset_m) - 0.05
        if offset_m <= self.right_edge_m or offset_m >= self.left_edge_m:
            visible &= ~self._between(points, self.right_edge_m + 0.1, self.left_edge_m - 0.1)
        return points, visible

    def lateral_m(self, points_m: np.ndarray) -> np.ndarray:
        """Return the lateral offsets (N,) of points (N, 2) from the nearest pass of the route.

        They are positive to the left of the route, and infinite where no pass is within about 10 m.
        """
        return self._segments.nearest_offsets(np.asarray(points_m, float).reshape(-1, 2))

    def off_lane(self, points_m: np.ndarray) -> np.ndarray:
        """Return the mask (N,) of the points (N, 2) that are in the right-hand lane of no pass."""
        return ~self._between(points_m, self.right_edge_m, self.centre_line_m)

    def on_road(self, points_m: np.ndarray, margin_m: float = 0.0) -> np.ndarray:
        """Return the mask (N,) of the points (N, 2) between the solid lines of any pass.

        Args:
            points_m: (N, 2) points [m]
            margin_m: by how much to widen the road on each side, less than 4 [m]
        """
        return self._between(points_m, self.right_edge_m - margin_m, self.left_edge_m + margin_m)

    def _between(self, points_m: np.ndarray, lower_m: float, upper_m: float) -> np.ndarray:
        points = np.asarray(points_m, float).reshape(-1, 2)
        inside = np.zeros(len(points), bool)
        for rows, offsets in self._segments.offsets(points):
            inside[rows[(offsets >= lower_m) & (offsets <= upper_m)]] = True
        return inside
