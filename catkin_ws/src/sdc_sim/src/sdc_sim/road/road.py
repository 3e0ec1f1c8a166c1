"""A two-lane road laid along a route: where its lanes, edges and dashes are, and what stands beside it.

Everything is plain geometry in the ROS map frame (x forward, y left, metres). The route is the centre of the
right-hand lane, so seen along the route, with `w` the lane width and lateral offsets positive to the left:

    -w/2  right solid edge    +w/2  dashed centre line    +3w/2  left solid edge
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LINE_WIDTH_M = 0.15
DASH_LENGTH_M = 3.0
DASH_PERIOD_M = 9.0
MARGIN_M = 0.35  # asphalt beyond the solid lines
LEAD_IN_M = 30.0  # straight road drawn behind the first waypoint
LEAD_OUT_M = 80.0  # and beyond the last
SAMPLE_STEP_M = 0.5
MAX_SAMPLES = 600_000
MIN_SPACING_M = 0.2  # closer waypoints are merged
SMOOTHING_M = 1.5  # half the chord that gives the direction of the road
REPRESENTATIVE_CELL_M = 3.0
MAX_SCENERY_SLOTS = 20_000
CROWD_CELL_M = 24.0
REPEAT_TOLERANCE_M = 0.03
CHORD_TOLERANCE_M = 0.003  # between the road as drawn and the road as computed, at the outer edge


class CellIndex:
    """Numbered points or boxes in square cells, for finding those near a place.

    `lower_m`, `upper_m` (N, 2): corners of the boxes (equal for points). A box must not span more than
    `2 * cell_m` in either direction.
    """

    def __init__(self, lower_m: np.ndarray, upper_m: np.ndarray, cell_m: float):
        self.cell_m = float(cell_m)
        lower = np.floor(np.asarray(lower_m) / cell_m).astype(np.int64)
        upper = np.floor(np.asarray(upper_m) / cell_m).astype(np.int64)
        keys, owners = [], []
        for dx in range(3):
            for dy in range(3):
                inside = (lower[:, 0] + dx <= upper[:, 0]) & (lower[:, 1] + dy <= upper[:, 1])
                keys.append(self._key(lower[inside, 0] + dx, lower[inside, 1] + dy))
                owners.append(np.flatnonzero(inside))
        keys, owners = np.concatenate(keys), np.concatenate(owners)
        order = np.lexsort((owners, keys))
        self._owners = owners[order]
        self._keys, self._starts = np.unique(keys[order], return_index=True)
        self._ends = np.append(self._starts[1:], len(keys))
        self._slots = {int(key): slot for slot, key in enumerate(self._keys)}

    @staticmethod
    def _key(i, j):
        return i * 4_000_037 + j

    def near(self, lower_m, upper_m) -> np.ndarray:
        """Sorted numbers of the boxes in the cells that the rectangle `lower_m`..`upper_m` touches."""
        i0, j0 = (int(np.floor(v / self.cell_m)) for v in lower_m)
        i1, j1 = (int(np.floor(v / self.cell_m)) for v in upper_m)
        found = []
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                slot = self._slots.get(self._key(i, j))
                if slot is not None:
                    found.append(self._owners[self._starts[slot] : self._ends[slot]])
        if not found:
            return np.zeros(0, np.int64)
        return found[0] if len(found) == 1 else np.unique(np.concatenate(found))


@dataclass(frozen=True)
class Scenery:
    """What stands beside the road, one row each.

    `kind` (N,) 0 tree, 1 house, 2 block of flats; `position_m` (N, 2); `yaw_rad` (N,);
    `size_m` (N, 3) length, width, height; `variant` (N,) a number in 0..255 that picks colours and shapes.
    """

    kind: np.ndarray
    position_m: np.ndarray
    yaw_rad: np.ndarray
    size_m: np.ndarray
    variant: np.ndarray

    def __len__(self) -> int:
        return len(self.kind)


class Road:
    """The road along `route_m` (N, 2), N >= 2, in the map frame; lanes are `lane_width_m` wide.

    The route may be of any spacing and may cross or overlap itself. Waypoints nearer than 0.2 m to the one before are
    merged and the direction is taken over a chord of 3 m, so noise does not turn the road. It is drawn on, straight,
    30 m behind the start and 80 m beyond the end, as far as it does not meet itself there. A lap that runs within
    3 cm of an earlier one counts as the same road.

    `points_m` (M, 2), `heading_rad` (M,), `left` (M, 2) unit vector to the left and `s_m` (M,) sample the road every
    0.5 m; `s_m` is 0 at the first waypoint, `length_m` at the last, negative on the lead-in.

    Raises ValueError for an array of another shape, numbers that are not finite, fewer than two distinct waypoints,
    or a lane width that is not positive.
    """

    def __init__(self, route_m, lane_width_m: float = 3.5):
        route = np.asarray(route_m, dtype=float)
        if route.ndim != 2 or route.shape[1] != 2 or len(route) < 2:
            raise ValueError(
                f"a route is an (N, 2) array with N >= 2, not one of shape {route.shape}"
            )
        if not np.all(np.isfinite(route)):
            raise ValueError(
                f"route: row {int(np.argmin(np.isfinite(route).all(axis=1)))} is not finite"
            )
        if not (np.isfinite(lane_width_m) and lane_width_m > 0):
            raise ValueError(f"lane_width_m must be positive, not {lane_width_m}")
        route = _merge_close(route)
        if len(route) < 2:
            raise ValueError("the route has fewer than two distinct waypoints")

        self.lane_width_m = float(lane_width_m)
        self.right_edge_m = -0.5 * self.lane_width_m
        self.centre_line_m = 0.5 * self.lane_width_m
        self.left_edge_m = 1.5 * self.lane_width_m
        self._lay(route)
        self._rep_keys, self._reps = self._representatives()

    def _lay(self, route: np.ndarray) -> None:
        s_route = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(route, axis=0), axis=1)))
        self.length_m = float(s_route[-1])
        step = max(SAMPLE_STEP_M, self.length_m / MAX_SAMPLES)
        count = max(2, int(round(self.length_m / step)) + 1)
        s = np.linspace(0.0, self.length_m, count)
        points = np.column_stack([np.interp(s, s_route, route[:, k]) for k in (0, 1)])
        ahead, behind = np.minimum(s + SMOOTHING_M, self.length_m), np.maximum(s - SMOOTHING_M, 0.0)
        chord = np.column_stack(
            [
                np.interp(ahead, s_route, route[:, k]) - np.interp(behind, s_route, route[:, k])
                for k in (0, 1)
            ]
        )
        plain = np.gradient(points, axis=0)
        short = np.linalg.norm(chord, axis=1) < 0.3 * (ahead - behind)
        chord[short] = plain[short]
        chord[np.linalg.norm(chord, axis=1) < 1e-9] = route[1] - route[0]
        direction = chord / np.linalg.norm(chord, axis=1)[:, None]

        lead_in = self._lead(points, points[0], -direction[0], LEAD_IN_M)
        lead_out = self._lead(points, points[-1], direction[-1], LEAD_OUT_M)
        self.points_m = np.concatenate([lead_in[::-1], points, lead_out])
        self.s_m = np.concatenate(
            [
                -SAMPLE_STEP_M * np.arange(len(lead_in), 0, -1),
                s,
                self.length_m + SAMPLE_STEP_M * np.arange(1, len(lead_out) + 1),
            ]
        )
        direction = np.concatenate(
            [
                np.repeat(direction[:1], len(lead_in), axis=0),
                direction,
                np.repeat(direction[-1:], len(lead_out), axis=0),
            ]
        )
        self.heading_rad = np.arctan2(direction[:, 1], direction[:, 0])
        self.left = np.column_stack([-direction[:, 1], direction[:, 0]])
        self.repeats = self._find_repeats()
        self._own = np.flatnonzero(~(self.repeats[:-1] & self.repeats[1:]))
        a, b = self.points_m[self._own], self.points_m[self._own + 1]
        self._cell_m = max(10.0, 2.0 * self.lane_width_m, step)
        self._segments = CellIndex(np.minimum(a, b), np.maximum(a, b), self._cell_m)

    def _find_repeats(self) -> np.ndarray:
        """Mask (M,) of the samples where the route runs, the same way, on a line it has run on before (laps)."""
        cells = np.floor(self.points_m / SAMPLE_STEP_M).astype(np.int64)
        keys, firsts = np.unique(CellIndex._key(cells[:, 0], cells[:, 1]), return_index=True)
        repeats = np.zeros(len(cells), bool)
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                key = CellIndex._key(cells[:, 0] + i, cells[:, 1] + j)
                slot = np.minimum(np.searchsorted(keys, key), len(keys) - 1)
                first = firsts[slot]
                rows = np.flatnonzero((keys[slot] == key) & (first < np.arange(len(cells)) - 40))
                first = first[rows]
                across = np.sum(
                    (self.points_m[rows] - self.points_m[first]) * self.left[first], axis=1
                )
                along = np.sum(self.left[rows] * self.left[first], axis=1)
                repeats[rows[(np.abs(across) < REPEAT_TOLERANCE_M) & (along > 0.999)]] = True
        return repeats

    def _lead(
        self, points: np.ndarray, start: np.ndarray, direction: np.ndarray, length_m: float
    ) -> np.ndarray:
        lead = (
            start
            + direction * (SAMPLE_STEP_M * np.arange(1, int(length_m / SAMPLE_STEP_M) + 1))[:, None]
        )
        lower, upper = np.minimum(start, lead[-1]) - 12.0, np.maximum(start, lead[-1]) + 12.0
        others = points[np.all((points >= lower) & (points <= upper), axis=1)][::4]
        along = (others - start) @ direction
        across = np.abs((others - start) @ np.array([-direction[1], direction[0]]))
        meeting = along[(along > 1.0) & (across < 4.0 * self.lane_width_m)]
        clear_m = (
            length_m
            if len(meeting) == 0
            else max(0.0, float(meeting.min()) - 3.0 * self.lane_width_m)
        )
        return lead[: int(clear_m / SAMPLE_STEP_M)]

    def stations(
        self, tolerance_m: float = CHORD_TOLERANCE_M, longest_m: float = 8.0
    ) -> np.ndarray:
        """Numbers of the samples between which the road, edges included, is within `tolerance_m` of straight."""
        turn = np.abs(np.diff(np.unwrap(self.heading_rad)))
        step = np.diff(self.s_m)
        reach = 1.5 * self.lane_width_m + 1.0
        kept = [0]
        length = angle = 0.0
        for i, (d, a) in enumerate(zip(step.tolist(), turn.tolist())):
            bow = (length + d + reach * (angle + a)) * (angle + a) / 8.0
            if length > 0.0 and (length + d > longest_m or bow > tolerance_m):
                kept.append(i)
                length = angle = 0.0
            length += d
            angle += a
        kept.append(len(self.s_m) - 1)
        return np.array(kept)

    def at(self, s_m) -> tuple:
        """Points (N, 2) and unit vectors to the left (N, 2) of the route at the distances `s_m` (N,), clamped."""
        points = np.column_stack([np.interp(s_m, self.s_m, self.points_m[:, k]) for k in (0, 1)])
        left = np.column_stack([np.interp(s_m, self.s_m, self.left[:, k]) for k in (0, 1)])
        return points, left / np.maximum(np.linalg.norm(left, axis=1), 1e-9)[:, None]

    def lane_points(
        self,
        offset_m: float,
        start_m: float = 0.0,
        end_m: float | None = None,
        step_m: float = SAMPLE_STEP_M,
    ) -> tuple:
        """The line `offset_m` to the left of the route, every `step_m` from `start_m` to `end_m` along the route.

        Returns points (N, 2) and a mask (N,) that is False where the line is not seen: where it folds over itself
        inside a tight turn, or where another pass of the road lies on it.
        """
        end_m = self.length_m if end_m is None else end_m
        s = start_m + step_m * np.arange(max(1, int((end_m - start_m) / step_m + 1e-9) + 1))
        points, left = self.at(s)
        points = points + offset_m * left
        near, lateral = self._nearest(points)
        seen = near > abs(offset_m) - 0.05
        if offset_m <= self.right_edge_m or offset_m >= self.left_edge_m:
            seen &= ~self._between(points, self.right_edge_m + 0.1, self.left_edge_m - 0.1)
        return points, seen

    def lateral_m(self, points_m) -> np.ndarray:
        """Signed distance (N,) of `points_m` (N, 2) to the nearest pass of the route, positive to its left.

        Infinite where no pass is within one lane pair's reach (about 10 m).
        """
        return self._nearest(np.asarray(points_m, float).reshape(-1, 2))[1]

    def off_lane(self, points_m) -> np.ndarray:
        """Mask (N,) of the `points_m` (N, 2) that are not in the right-hand lane of any pass."""
        return ~self._between(points_m, self.right_edge_m, self.centre_line_m)

    def on_road(self, points_m, margin_m: float = 0.0) -> np.ndarray:
        """Mask (N,) of the `points_m` (N, 2) between the solid lines of any pass, widened by `margin_m` (< 4)."""
        return self._between(points_m, self.right_edge_m - margin_m, self.left_edge_m + margin_m)

    def _between(self, points_m, lower_m: float, upper_m: float) -> np.ndarray:
        points = np.asarray(points_m, float).reshape(-1, 2)
        inside = np.zeros(len(points), bool)
        for rows, distance, side in self._relations(points):
            lateral = distance * side
            inside[rows] = np.any((lateral >= lower_m) & (lateral <= upper_m), axis=1)
        return inside

    def _nearest(self, points: np.ndarray) -> tuple:
        distance_m = np.full(len(points), np.inf)
        lateral_m = np.full(len(points), np.inf)
        for rows, distance, side in self._relations(points):
            best = np.argmin(distance, axis=1)
            pick = np.arange(len(rows)), best
            distance_m[rows] = distance[pick]
            lateral_m[rows] = distance[pick] * side[pick]
        return distance_m, lateral_m

    def _relations(self, points: np.ndarray):
        """Per cell: the rows of `points` in it, and their distance and side to every segment of the road nearby."""
        cells = np.floor(points / self._cell_m).astype(np.int64)
        keys, group = np.unique(CellIndex._key(cells[:, 0], cells[:, 1]), return_inverse=True)
        order = np.argsort(group, kind="stable")
        for rows in np.split(order, np.searchsorted(group[order], np.arange(1, len(keys)))):
            if len(rows) == 0:
                continue
            cell = cells[rows[0]]
            found = self._segments.near((cell - 1) * self._cell_m, (cell + 1.5) * self._cell_m)
            if len(found) == 0:
                continue
            a, b = self.points_m[self._own[found]], self.points_m[self._own[found] + 1]
            along = b - a
            for part in np.array_split(rows, 1 + len(rows) * len(found) // 2_000_000):
                offset = points[part][:, None] - a
                t = np.clip(
                    np.sum(offset * along, axis=2)
                    / np.maximum(np.sum(along * along, axis=1), 1e-12),
                    0.0,
                    1.0,
                )
                rest = offset - t[..., None] * along
                side = np.where(
                    along[:, 0] * rest[..., 1] - along[:, 1] * rest[..., 0] >= 0.0, 1.0, -1.0
                )
                yield part, np.hypot(rest[..., 0], rest[..., 1]), side

    def clearance_m(self, points_m) -> np.ndarray:
        """Free distance (N,) from `points_m` (N, 2) to the asphalt of the nearest pass, 12 at most, right to 0.5."""
        points = np.asarray(points_m, float).reshape(-1, 2)
        cell_m, keys = REPRESENTATIVE_CELL_M, self._rep_keys
        clear = np.full(len(points), 12.0)
        base = np.floor(points / cell_m).astype(np.int64)
        reach = int(np.ceil((12.0 + self.left_edge_m) / cell_m))
        for dx in range(-reach, reach + 1):
            for dy in range(-reach, reach + 1):
                if (max(abs(dx), abs(dy)) - 1) * cell_m > 12.0 + self.left_edge_m:
                    continue
                key = CellIndex._key(base[:, 0] + dx, base[:, 1] + dy)
                slot = np.minimum(np.searchsorted(keys, key), len(keys) - 1)
                hit = np.flatnonzero(keys[slot] == key)
                sample = self._reps[slot[hit]]
                offset = points[hit] - self.points_m[sample]
                lateral = np.sum(offset * self.left[sample], axis=1)
                along = np.sum(
                    offset * np.column_stack([self.left[sample, 1], -self.left[sample, 0]]), axis=1
                )
                beside = np.maximum(lateral - self.left_edge_m, self.right_edge_m - lateral)
                free = (
                    np.hypot(np.maximum(beside, 0.0), np.maximum(np.abs(along) - cell_m, 0.0))
                    - MARGIN_M
                )
                np.minimum.at(clear, hit, free)
        return clear

    def _representatives(self) -> tuple:
        """One sample a cell is enough to keep scenery off the road, however often the route laps."""
        cells = np.floor(self.points_m / REPRESENTATIVE_CELL_M).astype(np.int64)
        return np.unique(CellIndex._key(cells[:, 0], cells[:, 1]), return_index=True)

    def scenery(self, seed: int = 0) -> Scenery:
        """Trees and buildings beside the road, none on any pass of it; the same for the same road and `seed`."""
        rng = np.random.RandomState(seed)
        slots = np.arange(self.s_m[0], self.s_m[-1], max(11.0, self.length_m / MAX_SCENERY_SLOTS))
        count = 2 * len(slots)
        s = np.repeat(slots, 2) + rng.uniform(-3.0, 3.0, count)
        side = np.tile([-1.0, 1.0], len(slots))
        points, left = self.at(s)
        town = np.repeat(np.sin(slots / 170.0 + rng.uniform(0, 6)) + 0.3, 2)
        draw = rng.uniform(size=count)
        kind = np.where(
            draw < 0.22 + 0.2 * town, np.where(rng.uniform(size=count) < 0.5 + 0.2 * town, 2, 1), 0
        )
        size = np.empty((count, 3))
        tree_height = rng.uniform(5.0, 9.5, count)
        size[:] = np.column_stack([0.75 * tree_height, 0.75 * tree_height, tree_height])
        house, block = kind == 1, kind == 2
        size[house] = np.column_stack(
            [rng.uniform(9, 13, count), rng.uniform(7, 9, count), rng.uniform(6.5, 8.5, count)]
        )[house]
        size[block] = np.column_stack(
            [
                rng.uniform(13, 20, count),
                rng.uniform(10, 13, count),
                3.1 * rng.randint(3, 7, count) + 0.8,
            ]
        )[block]
        setback = np.where(kind == 0, rng.uniform(2.5, 9.0, count), rng.uniform(5.0, 9.0, count))
        edge = np.where(side < 0, self.right_edge_m - MARGIN_M, self.left_edge_m + MARGIN_M)
        depth = np.where(kind == 0, 0.0, 0.5 * size[:, 1])
        position = points + (edge + side * (setback + depth))[:, None] * left
        yaw = np.arctan2(-left[:, 0], left[:, 1])
        radius = np.where(kind == 0, 0.35 * size[:, 0], 0.5 * np.hypot(size[:, 0], size[:, 1]))
        variant = rng.randint(0, 256, count)
        needed = np.where(kind == 0, 1.5, 4.0 + depth)
        # The quick look at a sample a cell first, the exact one at what is left.
        fits = self.clearance_m(position) >= np.minimum(needed, 11.0)
        for corner in ((1, 1), (1, -1), (-1, -1), (-1, 1)):
            along = np.column_stack([left[:, 1], -left[:, 0]])
            probe = (
                position
                + 0.5 * corner[0] * size[:, :1] * along
                + 0.5 * corner[1] * size[:, 1:2] * left
            )
            fits &= (kind == 0) | (self.clearance_m(probe) >= 2.5)
        fits = np.flatnonzero(fits)
        chosen = _without_overlap(
            fits[self._stands_free(kind[fits], position[fits], yaw[fits], size[fits])],
            kind,
            position,
            radius,
        )
        return Scenery(kind[chosen], position[chosen], yaw[chosen], size[chosen], variant[chosen])

    def _crowded_cells(self) -> np.ndarray:
        """Keys of the cells that the road comes through more than once."""
        cells = np.floor(self.points_m / CROWD_CELL_M).astype(np.int64)
        keys = CellIndex._key(cells[:, 0], cells[:, 1])
        entered = np.append(True, np.diff(keys) != 0)
        found, visits = np.unique(keys[entered], return_counts=True)
        twisted = keys[:-1][np.abs(np.diff(np.unwrap(self.heading_rad))) > 0.2]
        return np.unique(np.concatenate([found[visits > 1], twisted]))

    def _stands_free(
        self, kind: np.ndarray, position: np.ndarray, yaw: np.ndarray, size: np.ndarray
    ) -> np.ndarray:
        """Mask (N,) of the trees and buildings with no pass's roadway within or near them.

        Exact, so slow: looked at only where more than one pass comes by, as `clearance_m` knows one a cell.
        """
        free = np.ones(len(kind), bool)
        crowded = self._crowded_cells()
        cells = np.floor(position / CROWD_CELL_M).astype(np.int64)
        around = np.stack(
            [
                CellIndex._key(cells[:, 0] + i, cells[:, 1] + j)
                for i in (-1, 0, 1)
                for j in (-1, 0, 1)
            ]
        )
        doubtful = np.isin(around, crowded).any(axis=0)
        free[doubtful] = ~self.on_road(position[doubtful], 1.2)
        built = np.flatnonzero((kind != 0) & free & doubtful)
        u, v = (
            grid.ravel()
            for grid in np.meshgrid(np.linspace(-0.5, 0.5, 5), np.linspace(-0.5, 0.5, 4))
        )
        x, y = u * size[built, :1], v * size[built, 1:2]
        c, s = np.cos(yaw[built])[:, None], np.sin(yaw[built])[:, None]
        probes = position[built][:, None] + np.stack([c * x - s * y, s * x + c * y], axis=2)
        free[built] = ~self.on_road(probes.reshape(-1, 2), 3.0).reshape(len(built), len(u)).any(
            axis=1
        )
        return free


def _merge_close(route: np.ndarray) -> np.ndarray:
    """The waypoints at least MIN_SPACING_M from the one kept before; the last one always stays."""
    if np.all(np.hypot(*np.diff(route, axis=0).T) >= MIN_SPACING_M):
        return route
    kept = [0]
    x0, y0 = route[0]
    for i, (x, y) in enumerate(route.tolist()):
        if (x - x0) ** 2 + (y - y0) ** 2 >= MIN_SPACING_M**2:
            kept.append(i)
            x0, y0 = x, y
    last = len(route) - 1
    if kept[-1] != last and np.hypot(*(route[last] - route[kept[-1]])) > 1e-6:
        if len(kept) > 1:
            kept[-1] = last
        else:
            kept.append(last)
    return route[kept]


def _without_overlap(
    candidates: np.ndarray, kind: np.ndarray, position: np.ndarray, radius: np.ndarray
) -> np.ndarray:
    """Candidates in order, buildings first, without those that touch one chosen before."""
    cell_m = 24.0
    taken = {}
    chosen = []
    for i in sorted(candidates.tolist(), key=lambda i: (kind[i] == 0, i)):
        x, y = position[i]
        r = radius[i]
        cx, cy = int(x // cell_m), int(y // cell_m)
        around = [
            other
            for dx in (-1, 0, 1)
            for dy in (-1, 0, 1)
            for other in taken.get((cx + dx, cy + dy), ())
        ]
        if all((x - ox) ** 2 + (y - oy) ** 2 > (r + orad + 0.5) ** 2 for ox, oy, orad in around):
            taken.setdefault((cx, cy), []).append((x, y, r))
            chosen.append(i)
    return np.array(sorted(chosen), dtype=np.int64)
