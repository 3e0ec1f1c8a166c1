"""A two-lane road along a route: its samples, lanes, lines, edges and dashes.

All geometry is in the ROS map frame (x forward, y left, metres). The route is the centre of the
right-hand lane. With lane width `w` and lateral offsets positive to the left of the route:

    -w/2  right solid edge    +w/2  dashed centre line    +3w/2  left solid edge
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from sdc_common.geometry.polyline import Polyline
from sdc_common.geometry.road_line import road_line
from sdc_common.geometry.route import checked_points, interpolate
from sdc_sim.physics.traffic_lights import LANE_WIDTH_M
from sdc_sim.road.scenery import Scenery, generate_scenery

LINE_WIDTH_M = 0.15
DASH_LENGTH_M = 3.0
DASH_PERIOD_M = 9.0
MARGIN_M = 0.35  # asphalt outside the solid lines
# Points farther from the route than this count as off the road.
_REACH_M = 10.0
# So many points are compared with the segments at once, to bound the memory.
_POINTS_AT_ONCE = 4_000
SAMPLE_STEP_M = 0.5
_MAX_SAMPLES = 600_000
_LEAD_IN_M = 30.0
_LEAD_OUT_M = 80.0
# The direction of the drawn road is that of a chord. It follows a tight bend more closely than the
# smoothed heading of a Route: the RMS errors on the town's route are 0.25 and 0.29 degrees.
_HALF_CHORD_M = 1.5
# A lap that runs this close to an earlier one is the same road.
_REPEAT_TOLERANCE_M = 0.03
_REPEAT_AFTER_SAMPLES = 40
# Larger than the number of rows of any map, so that no two cells near each other share a key.
_COLUMN_STRIDE = 4_000_037
# Trees and buildings are placed at this distance, or at a larger one along a very long route.
_SLOT_M = 11.0
_MAX_SLOTS = 20_000


class Road:
    """Samples of a route and of straight stretches before its start and after its end.

    The route can have any spacing and can cross or overlap itself. The direction is taken over a
    chord of 3 m, so that noise does not turn the road. The line continues straight 30 m before the
    start and 80 m after the end, or less where it would meet itself.
    """

    lane_width_m = LANE_WIDTH_M
    # Lateral offsets of the right solid line, the dashed line and the left solid line.
    right_edge_m = -0.5 * LANE_WIDTH_M
    centre_line_m = 0.5 * LANE_WIDTH_M
    left_edge_m = 1.5 * LANE_WIDTH_M

    def __init__(self, route_m: np.ndarray):
        """Build the road of (N, 2) waypoints [m].

        Raises:
            ValueError: `checked_points` refuses the waypoints
        """
        self._sample(road_line(checked_points(route_m)))
        # Mask (M,) of the samples that lie, in the same direction, on an earlier lap.
        self.repeats = self._find_repeats()
        own = np.flatnonzero(~(self.repeats[:-1] & self.repeats[1:]))
        # All segments near points are found with a KD-tree of their middles; `Polyline.nearest` is
        # faster for one point and a few segments.
        self._starts, self._steps = self.points_m[own], self.points_m[own + 1] - self.points_m[own]
        self._middles = cKDTree(self._starts + 0.5 * self._steps)
        longest_m = float(np.linalg.norm(self._steps, axis=1).max())
        self._radius_m = _REACH_M + 0.5 * longest_m

    def _sample(self, route: np.ndarray) -> None:
        s_route = np.array(Polyline(route.tolist()).s)
        self.length_m = float(s_route[-1])  # arc length of the last waypoint
        step = max(SAMPLE_STEP_M, self.length_m / _MAX_SAMPLES)
        s = np.linspace(0.0, self.length_m, max(2, int(round(self.length_m / step)) + 1))
        points = interpolate(s, s_route, route)
        direction = _chord_directions(route, s_route, s)

        lead_in = _straight(points, points[0], -direction[0], _LEAD_IN_M)
        lead_out = _straight(points, points[-1], direction[-1], _LEAD_OUT_M)
        # Samples (M, 2) in the map, with their arc length (M,): 0 at the first waypoint.
        self.points_m = np.concatenate([lead_in[::-1], points, lead_out])
        before = -SAMPLE_STEP_M * np.arange(len(lead_in), 0, -1)
        after = self.length_m + SAMPLE_STEP_M * np.arange(1, len(lead_out) + 1)
        self.s_m = np.concatenate([before, s, after])
        direction = np.pad(direction, ((len(lead_in), len(lead_out)), (0, 0)), mode="edge")
        # Direction (M,) of the road in (-pi, pi], and unit vectors (M, 2) to its left.
        self.heading_rad = np.arctan2(direction[:, 1], direction[:, 0])
        self.left = np.column_stack([-direction[:, 1], direction[:, 0]])

    def _find_repeats(self) -> np.ndarray:
        cells = np.floor(self.points_m / SAMPLE_STEP_M).astype(np.int64)
        cell_keys = cells[:, 0] * _COLUMN_STRIDE + cells[:, 1]
        keys, firsts = np.unique(cell_keys, return_index=True)
        repeats = np.zeros(len(cells), bool)
        numbers = np.arange(len(cells))
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                key = cell_keys + i * _COLUMN_STRIDE + j
                slot = np.minimum(np.searchsorted(keys, key), len(keys) - 1)
                first = firsts[slot]
                rows = np.flatnonzero(
                    (keys[slot] == key) & (first < numbers - _REPEAT_AFTER_SAMPLES)
                )
                first = first[rows]
                offset = self.points_m[rows] - self.points_m[first]
                across = np.sum(offset * self.left[first], axis=1)
                along = np.sum(self.left[rows] * self.left[first], axis=1)
                repeats[rows[(np.abs(across) < _REPEAT_TOLERANCE_M) & (along > 0.999)]] = True
        return repeats

    def at(self, s_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return points (N, 2) on the line at arc lengths [m], and unit vectors to the left."""
        points = interpolate(s_m, self.s_m, self.points_m)
        left = interpolate(s_m, self.s_m, self.left)
        return points, left / np.maximum(np.linalg.norm(left, axis=1), 1e-9)[:, None]

    def scenery(self, seed: int = 0) -> Scenery:
        """Return trees and buildings next to the road, the same for the same road and seed."""
        right_m, left_m = self.right_edge_m - MARGIN_M, self.left_edge_m + MARGIN_M
        slot_m = max(_SLOT_M, self.length_m / _MAX_SLOTS)
        slots_m = np.arange(self.s_m[0], self.s_m[-1], slot_m)
        return generate_scenery(self.at, slots_m, (right_m, left_m), self.on_road, seed)

    def on_road(self, points_m: np.ndarray, margin_m: float = 0.0) -> np.ndarray:
        """Return the mask (N,) of the points (N, 2) between the solid lines of any pass.

        The margin on each side is less than 4 m.
        """
        return self.between(points_m, self.right_edge_m - margin_m, self.left_edge_m + margin_m)

    def between(self, points_m: np.ndarray, lower_m: float, upper_m: float) -> np.ndarray:
        """Return the mask (N,) of the points (N, 2) whose lateral offset from any pass is between.

        Offsets are positive to the left of the route, and at most 10 m.
        """
        points_m = np.asarray(points_m, float).reshape(-1, 2)
        inside = np.zeros(len(points_m), bool)
        for first in range(0, len(points_m), _POINTS_AT_ONCE):
            part = points_m[first : first + _POINTS_AT_ONCE]
            pairs = cKDTree(part).sparse_distance_matrix(
                self._middles, self._radius_m, output_type="ndarray"
            )
            rows, segments = pairs["i"], pairs["j"]
            step = self._steps[segments]
            offset = part[rows] - self._starts[segments]
            square = np.maximum(np.sum(step * step, axis=1), 1e-12)
            fraction = np.clip(np.sum(offset * step, axis=1) / square, 0.0, 1.0)
            away = offset - fraction[:, None] * step
            side = np.where(step[:, 0] * away[:, 1] - step[:, 1] * away[:, 0] >= 0.0, 1.0, -1.0)
            offsets = np.hypot(away[:, 0], away[:, 1]) * side
            inside[first + rows[(offsets >= lower_m) & (offsets <= upper_m)]] = True
        return inside


def _chord_directions(points_m: np.ndarray, s_m: np.ndarray, at_s_m: np.ndarray) -> np.ndarray:
    """Return the directions (M, 2) of the chords around arc lengths (M,) of a line."""
    ahead = np.minimum(at_s_m + _HALF_CHORD_M, s_m[-1])
    behind = np.maximum(at_s_m - _HALF_CHORD_M, 0.0)
    chord = interpolate(ahead, s_m, points_m) - interpolate(behind, s_m, points_m)
    # Where the line turns back on itself, a chord is too short to have a direction.
    short = np.linalg.norm(chord, axis=1) < 0.3 * (ahead - behind)
    chord[short] = np.gradient(interpolate(at_s_m, s_m, points_m), axis=0)[short]
    chord[np.linalg.norm(chord, axis=1) < 1e-9] = points_m[1] - points_m[0]
    return chord / np.linalg.norm(chord, axis=1)[:, None]


def _straight(
    points: np.ndarray, start: np.ndarray, direction: np.ndarray, length_m: float
) -> np.ndarray:
    """Return samples of a straight line from `start` that ends before it meets the other points."""
    steps = SAMPLE_STEP_M * np.arange(1, int(length_m / SAMPLE_STEP_M) + 1)
    line = start + direction * steps[:, None]
    lower, upper = np.minimum(start, line[-1]) - 12.0, np.maximum(start, line[-1]) + 12.0
    others = points[np.all((points >= lower) & (points <= upper), axis=1)][::4]
    along = (others - start) @ direction
    across = np.abs((others - start) @ np.array([-direction[1], direction[0]]))
    meeting = along[(along > 1.0) & (across < 4.0 * LANE_WIDTH_M)]
    free_m = max(0.0, float(meeting.min()) - 3.0 * LANE_WIDTH_M) if len(meeting) else length_m
    return line[: int(free_m / SAMPLE_STEP_M)]
