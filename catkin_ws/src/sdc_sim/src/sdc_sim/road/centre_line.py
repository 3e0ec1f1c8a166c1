"""The centre of the right-hand lane, sampled along a route."""

from __future__ import annotations

import numpy as np

from sdc_common.geometry.polyline import Polyline
from sdc_common.geometry.road_line import road_line
from sdc_common.geometry.route import chord_directions, interpolate

SAMPLE_STEP_M = 0.5
_MAX_SAMPLES = 600_000
_LEAD_IN_M = 30.0
_LEAD_OUT_M = 80.0
_MIN_SPACING_M = 0.2
# The direction of the drawn road is that of a chord. It follows a tight bend more closely than the
# smoothed heading of a Route: the RMS errors on the town's route are 0.25 and 0.29 degrees.
_HALF_CHORD_M = 1.5
# A lap that runs this close to an earlier one is the same road.
_REPEAT_TOLERANCE_M = 0.03
_REPEAT_AFTER_SAMPLES = 40
_CHORD_TOLERANCE_M = 0.003


class CentreLine:
    """Samples of a route and of straight stretches before its start and after its end.

    The route can have any spacing and can cross or overlap itself. Waypoints less than 0.2 m apart
    are merged, and the direction is taken over a chord of 3 m, so that noise does not turn the
    road. The line continues straight 30 m before the start and 80 m after the end, or less where it
    would meet itself.

    Attributes:
        points_m: (M, 2) samples, every 0.5 m, in the map frame [m]
        s_m: (M,) arc length: 0 at the first waypoint, negative before it [m]
        heading_rad: (M,) direction of the road, in (-pi, pi] [rad]
        left: (M, 2) unit vectors to the left
        length_m: arc length of the last waypoint [m]
        repeats: (M,) mask of the samples that lie, in the same direction, on an earlier lap
    """

    def __init__(self, route_m: np.ndarray, reach_m: float):
        """Sample a route.

        Args:
            route_m: (N, 2) waypoints, N >= 2 [m]
            reach_m: how far the road reaches to a side, for ending the line before it meets itself
                [m]

        Raises:
            ValueError: the shape is not (N, 2), a number is not finite, or all waypoints coincide
        """
        route = _merge_close(road_line(_checked(route_m)))
        s_route = np.array(Polyline(route.tolist()).s)
        self.length_m = float(s_route[-1])
        step = max(SAMPLE_STEP_M, self.length_m / _MAX_SAMPLES)
        s = np.linspace(0.0, self.length_m, max(2, int(round(self.length_m / step)) + 1))
        points = interpolate(s, s_route, route)
        direction = chord_directions(route, s_route, s, _HALF_CHORD_M)

        lead_in = _straight(points, points[0], -direction[0], _LEAD_IN_M, reach_m)
        lead_out = _straight(points, points[-1], direction[-1], _LEAD_OUT_M, reach_m)
        self.points_m = np.concatenate([lead_in[::-1], points, lead_out])
        before = -SAMPLE_STEP_M * np.arange(len(lead_in), 0, -1)
        after = self.length_m + SAMPLE_STEP_M * np.arange(1, len(lead_out) + 1)
        self.s_m = np.concatenate([before, s, after])
        direction = np.pad(direction, ((len(lead_in), len(lead_out)), (0, 0)), mode="edge")
        self.heading_rad = np.arctan2(direction[:, 1], direction[:, 0])
        self.left = np.column_stack([-direction[:, 1], direction[:, 0]])
        self.repeats = self._find_repeats()

    def at(self, s_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return points on the line and unit vectors to the left.

        Args:
            s_m: (N,) arc lengths, clamped to the line [m]

        Returns:
            (N, 2) points [m] and (N, 2) vectors
        """
        points = interpolate(s_m, self.s_m, self.points_m)
        left = interpolate(s_m, self.s_m, self.left)
        return points, left / np.maximum(np.linalg.norm(left, axis=1), 1e-9)[:, None]

    def stations_within(self, reach_m: float, tolerance_m: float, longest_m: float) -> np.ndarray:
        """Return the indices of samples between which the road is straight.

        Args:
            reach_m: how far the road reaches to a side [m]
            tolerance_m: largest distance between the road and a straight piece of it [m]
            longest_m: longest distance between two stations [m]
        """
        turns = np.abs(np.diff(np.unwrap(self.heading_rad))).tolist()
        kept = [0]
        length = angle = 0.0
        for i, (step, turn) in enumerate(zip(np.diff(self.s_m).tolist(), turns)):
            bow = (length + step + reach_m * (angle + turn)) * (angle + turn) / 8.0
            if length > 0.0 and (length + step > longest_m or bow > tolerance_m):
                kept.append(i)
                length = angle = 0.0
            length += step
            angle += turn
        kept.append(len(self.s_m) - 1)
        return np.array(kept)

    def _find_repeats(self) -> np.ndarray:
        cells = cells_of(self.points_m, SAMPLE_STEP_M)
        keys, firsts = np.unique(cell_keys(cells), return_index=True)
        repeats = np.zeros(len(cells), bool)
        numbers = np.arange(len(cells))
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                key = cell_keys(cells + (i, j))
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


def _checked(route_m: np.ndarray) -> np.ndarray:
    route = np.asarray(route_m, dtype=float)
    if route.ndim != 2 or route.shape[1] != 2 or len(route) < 2:
        raise ValueError(f"a route is an (N, 2) array with N >= 2, got shape {route.shape}")
    finite = np.isfinite(route).all(axis=1)
    if not finite.all():
        raise ValueError(f"row {int(np.argmin(finite))} of the route is not finite")
    return route


def _merge_close(route: np.ndarray) -> np.ndarray:
    """Return the waypoints that are far enough from the one kept before, and the last one."""
    if len(route) > 1 and np.all(np.hypot(*np.diff(route, axis=0).T) >= _MIN_SPACING_M):
        return route
    kept = [0]
    x0, y0 = route[0]
    for i, (x, y) in enumerate(route.tolist()):
        if (x - x0) ** 2 + (y - y0) ** 2 >= _MIN_SPACING_M**2:
            kept.append(i)
            x0, y0 = x, y
    last = len(route) - 1
    if kept[-1] != last and np.hypot(*(route[last] - route[kept[-1]])) > 1e-6:
        if len(kept) > 1:
            kept[-1] = last
        else:
            kept.append(last)
    if len(kept) < 2:
        raise ValueError("the route has fewer than two distinct waypoints")
    return route[kept]


def _straight(
    points: np.ndarray, start: np.ndarray, direction: np.ndarray, length_m: float, reach_m: float
) -> np.ndarray:
    """Return samples of a straight line from `start` that ends before it meets the other points."""
    steps = SAMPLE_STEP_M * np.arange(1, int(length_m / SAMPLE_STEP_M) + 1)
    line = start + direction * steps[:, None]
    lower, upper = np.minimum(start, line[-1]) - 12.0, np.maximum(start, line[-1]) + 12.0
    others = points[np.all((points >= lower) & (points <= upper), axis=1)][::4]
    along = (others - start) @ direction
    across = np.abs((others - start) @ np.array([-direction[1], direction[0]]))
    meeting = along[(along > 1.0) & (across < 4.0 * reach_m)]
    free_m = max(0.0, float(meeting.min()) - 3.0 * reach_m) if len(meeting) else length_m
    return line[: int(free_m / SAMPLE_STEP_M)]


# Larger than the number of rows of any map, so that no two cells near each other share a key.
_COLUMN_STRIDE = 4_000_037


def cell_keys(cells: np.ndarray) -> np.ndarray:
    """Return one integer for each cell.

    Args:
        cells: (..., 2) column and row of the cells
    """
    return cells[..., 0] * _COLUMN_STRIDE + cells[..., 1]


def cells_of(points_m: np.ndarray, cell_m: float) -> np.ndarray:
    """Return column and row of the cells in which points lie.

    Args:
        points_m: (N, 2) points [m]
        cell_m: side of a cell [m]

    Returns:
        (N, 2) integers
    """
    return np.floor(np.asarray(points_m) / cell_m).astype(np.int64)


class CellIndex:
    """Boxes in square cells, for finding those near a place.

    A SciPy KD-tree finds points, not boxes; Shapely's STRtree has different interfaces in versions
    1.8 and 2.0.
    """

    def __init__(self, lower_m: np.ndarray, upper_m: np.ndarray, cell_m: float):
        """Put boxes into cells.

        Args:
            lower_m: (N, 2) lower corners of the boxes [m]
            upper_m: (N, 2) upper corners, at most `2 * cell_m` from the lower ones in x and y [m]
            cell_m: side of a cell [m]
        """
        self.cell_m = float(cell_m)
        lower, upper = cells_of(lower_m, cell_m), cells_of(upper_m, cell_m)
        keys, owners = [], []
        for dx in range(3):
            for dy in range(3):
                inside = (lower[:, 0] + dx <= upper[:, 0]) & (lower[:, 1] + dy <= upper[:, 1])
                keys.append(cell_keys(lower[inside] + (dx, dy)))
                owners.append(np.flatnonzero(inside))
        all_keys, all_owners = np.concatenate(keys), np.concatenate(owners)
        order = np.lexsort((all_owners, all_keys))
        owners_by_cell = all_owners[order]
        found, starts = np.unique(all_keys[order], return_index=True)
        self._owners = {
            int(key): part for key, part in zip(found, np.split(owners_by_cell, starts[1:]))
        }

    def near(self, lower_m: np.ndarray, upper_m: np.ndarray) -> np.ndarray:
        """Return the sorted numbers of the boxes in all cells that a rectangle touches.

        Args:
            lower_m: (2,) lower corner of the rectangle [m]
            upper_m: (2,) upper corner of the rectangle [m]
        """
        first, last = cells_of(lower_m, self.cell_m), cells_of(upper_m, self.cell_m)
        found = []
        for i in range(first[0], last[0] + 1):
            for j in range(first[1], last[1] + 1):
                owners = self._owners.get(i * _COLUMN_STRIDE + j)
                if owners is not None:
                    found.append(owners)
        if not found:
            return np.zeros(0, np.int64)
        return found[0] if len(found) == 1 else np.unique(np.concatenate(found))
