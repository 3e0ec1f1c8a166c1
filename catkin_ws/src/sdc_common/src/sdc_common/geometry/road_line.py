"""The smooth line of the road that waypoints describe.

Waypoints are samples of a road. Where they are fine and exact, they are the road. Where they are
far apart, the road is the spline through them. Where they are noisy or rounded, the road is a
smoothing spline near them.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from sdc_common.geometry.route import Route, checked_points, interpolate
from sdc_common.geometry.smoothing_spline import SmoothingSpline

# Waypoints at these distances are points of the line as they are: closer ones only cost time, and
# two that are farther apart can follow neither a bend nor its speed profile.
SHORTEST_STEP_M = 0.8
LONGEST_STEP_M = 1.25
# Otherwise the points of the line are at most so far apart.
_STEP_M = 1.0
# A spline does not pass through waypoints that are closer together.
_SHORTEST_PIECE_M = 0.4
# The waypoints of a bend turn by less than this; a greater turn is a corner.
_CORNER_RAD = 0.6
# A piece that is so many times longer than the next one is straight if the road turns, where they
# meet, by less than this share of what it would turn in the bend of the next one.
_LONG_PIECE = 2.0
_STRAIGHT_SHARE = 0.35
# Noise may cause this curvature [1/m]: at 25 m/s, a lateral acceleration of 0.2 m/s^2.
_NOISE_CURVATURE = 3e-4
# With a greater distance between the waypoints, a beginning bend looks like noise.
_NOISE_SPACING_M = 6.0
# Quantiles of the absolute value of a normal distribution with standard deviation 1.
_NORMAL_QUANTILES = {0.3: 0.385, 0.5: 0.674, 0.9: 1.645}
_TURN_CHORD_M = 2.0
_ROUNDINGS_M = (0.1, 0.01, 0.001)
_SIGMA_PER_ROUNDING = 1.0 / math.sqrt(12.0)
# Waypoints arrive in messages as 32-bit numbers, with this relative error.
_FLOAT32_ERROR = 6e-8


def road_route(waypoints_m: np.ndarray) -> Route:
    """Return the route along the line of the road of (N, 2) waypoints [m].

    Raises:
        ValueError: `checked_points` refuses the waypoints
    """
    return _route(checked_points(waypoints_m).tobytes())


@lru_cache(maxsize=4)
def _route(waypoints: bytes) -> Route:
    """Return the route of checked waypoints. Planner and referee of each drive need the same."""
    return Route(road_line(np.frombuffer(waypoints).reshape(-1, 2)))


def road_line(waypoints_m: np.ndarray) -> np.ndarray:
    """Return the line of the road of (N, 2) waypoints as (M, 2) points about 1 m apart [m].

    Waypoints that are fine and exact are its points; one that repeats the last one is ignored.
    """
    points = waypoints_m[np.append(True, np.any(np.diff(waypoints_m, axis=0), axis=1))]
    if len(points) < 2:
        return points
    s = arc_lengths(points)
    spacing_m = float(np.median(np.diff(s)))
    noise_m = noise_of(points, s)
    if math.sqrt(6.0) * noise_m / spacing_m**2 > _NOISE_CURVATURE:
        width_m = (noise_m**2 * spacing_m / _NOISE_CURVATURE**2) ** 0.2
        spline = SmoothingSpline(s, points, spacing_m, noise_m, width_m)
        return spline(_even(0.0, s[-1]))
    return _interpolated(points, s)


def sharpest_turn(points_m: np.ndarray) -> tuple[float, int]:
    """Return the greatest angle between the chords 2 m before and 2 m after a point [rad].

    Returns:
        the angle and the row of the point among (N, 2) points; 0 and 0 for a line of two
    """
    s = arc_lengths(points_m)
    turns = turns_rad(points_m, s, s, _TURN_CHORD_M)
    turns[[0, -1]] = 0.0
    row = int(np.argmax(turns))
    return float(turns[row]), row


def turns_rad(points: np.ndarray, s: np.ndarray, at: np.ndarray, chord_m: float) -> np.ndarray:
    """Return the angles (M,) between the chords before and behind places `at` (M,) [rad].

    The line has points (N, 2) or (N, 3) at arc lengths `s` (N,).
    """
    before, place, behind = (interpolate(at + step, s, points) for step in (-chord_m, 0.0, chord_m))
    (x, y), (u, v) = (place - before).T[:2], (behind - place).T[:2]
    return np.abs(np.arctan2(x * v - y * u, x * u + y * v))


def noise_of(waypoints_m: np.ndarray, s_m: np.ndarray) -> float:
    """Return the standard deviation of waypoints from the road [m].

    The deviation of a waypoint is measured from the polynomial through three before and three after
    it. Some deviations are rather those of bends that begin there, so that the quantile with the
    lowest estimate counts.
    On a straight along x or y, rounded waypoints have no deviation: they are recognized by their
    decimals.
    """
    if len(waypoints_m) < 7:
        return 0.0
    deviations = _deviations(waypoints_m, s_m)
    noise_m = 0.0
    if np.median(np.diff(s_m)) <= _NOISE_SPACING_M:
        noise_m = min(
            float(np.quantile(deviations, share)) / normal
            for share, normal in _NORMAL_QUANTILES.items()
        )
    for step in _ROUNDINGS_M:
        error = np.abs(waypoints_m - step * np.round(waypoints_m / step))
        if (error <= _FLOAT32_ERROR * np.abs(waypoints_m) + 1e-9).all():
            sigma = step * _SIGMA_PER_ROUNDING
            if np.quantile(deviations, 0.95) > 0.3 * sigma:
                return max(noise_m, sigma)
            break
    return noise_m


def _deviations(points: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Return how far each point lies beside the curve of its six neighbours, as a noise [m]."""
    count = len(points) - 6
    near = [0, 1, 2, 4, 5, 6]
    s_of = {i: s[i : i + count] for i in range(7)}
    total = np.ones(count)
    offset = points[3 : 3 + count].copy()
    for i in near:
        weight = np.ones(count)
        for j in near:
            if j != i:
                weight *= (s_of[3] - s_of[j]) / (s_of[i] - s_of[j])
        total += weight * weight
        offset -= weight[:, None] * points[i : i + count]
    chord = points[6:] - points[:-6]
    length = np.maximum(np.hypot(*chord.T), 1e-9)
    sideways = (chord[:, 0] * offset[:, 1] - chord[:, 1] * offset[:, 0]) / length
    return np.abs(sideways) / np.sqrt(total)


def _interpolated(points: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Return the points, or evenly spaced points of the spline through them."""
    steps = np.diff(s)
    if steps.min() >= SHORTEST_STEP_M and steps.max() <= LONGEST_STEP_M:
        return points
    # A fifth of the time that a node needs to start.
    from scipy.interpolate import CubicSpline

    kept = _thinned(s)
    points, s = points[kept], s[kept]
    directions = _straight_beside(points, s)
    corners = np.flatnonzero(_turns(points) > _CORNER_RAD).tolist()
    ends = sorted({0, *corners, *directions, len(points) - 1})
    line = [points[:1]]
    for first, last in zip(ends, ends[1:]):
        piece, stations = slice(first, last + 1), _even(s[first], s[last])[1:]
        if last == first + 1:
            line.append(interpolate(stations, s[piece], points[piece]))
            continue
        lengths = np.diff(s[piece]).tolist()
        conditions = [
            (1, directions[end]) if end in directions else _free_end(*beside)
            for end, beside in ((first, lengths[:2]), (last, lengths[:-3:-1]))
        ]
        line.append(CubicSpline(s[piece], points[piece], bc_type=conditions)(stations))
    return np.vstack(line)


def _free_end(length_m: float, next_m: float) -> str:
    """Return the condition at an end of a spline: no curvature if its last piece is long."""
    return "natural" if length_m > _LONG_PIECE * next_m else "not-a-knot"


def _straight_beside(points: np.ndarray, s: np.ndarray) -> dict[int, np.ndarray]:
    """Return the rows where a long straight meets a bend, with the direction of the straight.

    A spline through both would swing out on the straight.
    """
    turns, lengths = _turns(points), np.diff(s)
    directions = np.diff(points, axis=0) / lengths[:, None]
    beside = 0.5 * (lengths[:-1] + lengths[1:])
    bends = np.zeros(len(points))
    bends[1:-1] = turns[1:-1] / beside
    found: dict[int, np.ndarray] = {}
    for step in (1, -1):
        rows = np.arange(1, len(points) - 2) + (step < 0)
        long, short = (rows - 1, rows) if step == 1 else (rows, rows - 1)
        in_bend = bends[rows + step] * beside[rows - 1]
        straight = lengths[long] > _LONG_PIECE * lengths[short]
        straight &= turns[rows] < _STRAIGHT_SHARE * in_bend
        found.update(zip(rows[straight].tolist(), directions[long[straight]]))
    return found


def _turns(points: np.ndarray) -> np.ndarray:
    """Return the angle (N,) by which the line turns at each point, 0 at its ends [rad]."""
    turns = np.zeros(len(points))
    headings = np.arctan2(*np.diff(points, axis=0).T[::-1])
    turns[1:-1] = np.abs((np.diff(headings) + math.pi) % (2.0 * math.pi) - math.pi)
    return turns


def arc_lengths(points: np.ndarray) -> np.ndarray:
    """Return the arc length (N,) on the ground at the points, (N, 2) or (N, 3), of a line [m]."""
    return np.append(0.0, np.cumsum(np.hypot(*np.diff(points[:, :2], axis=0).T)))


def _thinned(s: np.ndarray) -> np.ndarray:
    """Return the rows of the points that are far enough from the last one kept, and of the ends."""
    keep = [0]
    for row, place_m in enumerate(s[:-1].tolist()):
        if place_m - s[keep[-1]] >= _SHORTEST_PIECE_M:
            keep.append(row)
    return np.array([*keep, len(s) - 1])


def _even(start_m: float, end_m: float) -> np.ndarray:
    """Return arc lengths from start to end, evenly spaced."""
    return np.linspace(start_m, end_m, max(2, math.ceil((end_m - start_m) / _STEP_M - 1e-6) + 1))
