"""Lines that a car can drive: curves in place of the bends and jumps of a map."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Iterable, Iterator, Mapping, NamedTuple, Sequence

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from sdc_common.geometry.road_line import arc_lengths, turns_rad
from sdc_common.geometry.route import interpolate
from sdc_map.findings import Findings
from sdc_map.network import DRIVING, RoadLane, part_of

# Radius of the rear axle's circle at full steer [m]: CARLA's car, 2.87 m / tan(2/3 * 70 degrees).
LEAST_RADIUS_M = 2.7
# The turn at a place is the angle between the chords before and behind it, of this length [m].
_CHORD_M = 2.0
# Points of a mission are 1 m apart, so that its greatest turns are up to a twentieth greater.
_SHARPEST_RAD = 0.95 * _CHORD_M / LEAST_RADIUS_M
# Lanes that meet are bent if they turn by more, with chords of _STEP_M: a radius below 1.9 m.
_BENT_RAD = math.radians(15.0)
# Bends that are closer to each other are replaced by one curve [m].
_CLUSTER_M = 8.0
# A curve begins so far before the bends that it replaces, and ends so far behind them [m].
_MARGINS_M = (16.0, 8.0, 5.0, 3.0, 2.0)
# The longest curve is taken that is so close to the line [m], else the closest one.
_CLOSE_M = 0.3
# A curve that is farther from the line is not on the road [m].
_FARTHEST_M = 2.4
# A line that is farther from the curve leads around something [m].
_AROUND_CURVE_M = 4.0
_STEP_M = 0.5
# A road before and behind a connection is as long as a car needs to follow it [m]: what depends on
# further connections, a mission avoids.
_AROUND_M = 20.0
# A shorter line in a junction, and one between lanes that are closer to each other, is as long as
# its errors.
_SHORTEST_M = 0.5
# The direction of such a line is that of the lanes so close to it.
_NEAR_M = 1.0


class DrivableLine(NamedTuple):
    """A line with curves in place of the bends of another one."""

    points_m: np.ndarray  # (N, 2) [m]
    s_m: np.ndarray  # (N,) places of the points along the other line [m]
    lost_m: tuple[float, ...]  # places along the other line that no car can drive [m]


def drivable_line(points_m: np.ndarray, joints_m: Sequence[float]) -> DrivableLine:
    """Return a line with curves in place of what a car cannot drive.

    Args:
        points_m: (N, 2) points of the line [m]
        joints_m: places along it where two lanes meet [m]
    """
    s = arc_lengths(points_m)
    joints = np.array(joints_m)
    bent = joints[turns_rad(points_m, s, joints, _STEP_M) > _BENT_RAD]
    bends_m = np.sort(np.append(_sharp_m(points_m, s), bent))
    if not len(bends_m):
        return DrivableLine(points_m, s, ())
    clusters = np.split(bends_m, np.flatnonzero(np.diff(bends_m) > _CLUSTER_M) + 1)
    borders_m = [0.5 * (a[-1] + b[0]) for a, b in zip(clusters, clusters[1:])]
    parts, places, lost, begin = [], [], [], 0.0
    for cluster, low, high in zip(clusters, [0.0, *borders_m], [*borders_m, float(s[-1])]):
        found = _replacement(points_m, s, cluster, (low, high))
        if found is None:
            lost += cluster.tolist()
            continue
        start, end, points = found
        kept = (s >= begin) & (s < start)
        parts += [points_m[kept], points]
        places += [s[kept], np.linspace(start, end, len(points))]
        begin = end + 1e-6
    kept = s >= begin
    line = np.vstack([*parts, points_m[kept]])
    return DrivableLine(line, np.concatenate([*places, s[kept]]), tuple(lost))


def _sharp_m(points: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Return the places along a line at which it turns by more than a car can."""
    at = np.arange(_STEP_M, s[-1], _STEP_M)
    return at[turns_rad(points, s, at, _CHORD_M) > _SHARPEST_RAD]


def _replacement(
    points: np.ndarray, s: np.ndarray, bends_m: np.ndarray, within_m: tuple[float, float]
) -> tuple[float, float, np.ndarray] | None:
    """Return where a curve in place of some bends starts and ends, and its points; None if none."""
    found = []
    for margin_m in _MARGINS_M:
        start, end = (
            max(bends_m[0] - margin_m, within_m[0]),
            min(bends_m[-1] + margin_m, within_m[1]),
        )
        before = part_of(points, s, max(start - _CHORD_M, 0.0), start)
        behind = part_of(points, s, end, min(end + _CHORD_M, s[-1]))
        line = _curve(_end_of(before, _STEP_M), _end_of(behind[::-1], _STEP_M)[::-1])
        whole = np.vstack([before, line, behind])
        if len(_sharp_m(whole, arc_lengths(whole))):
            continue
        beside = part_of(points, s, start, end)
        beside = interpolate(np.arange(0.0, end - start, 0.1), arc_lengths(beside), beside)
        apart = np.hypot(*(line[:, None] - beside).transpose(2, 0, 1))
        beside_m, cut_m = apart.min(axis=1).max(), apart.min(axis=0).max()
        if beside_m <= _FARTHEST_M and cut_m <= _AROUND_CURVE_M:
            found.append((max(beside_m, cut_m), (start, end, line)))
    close = [row for distance_m, row in found if distance_m <= _CLOSE_M]
    _, closest = min(found, key=lambda row: row[0], default=(0.0, None))
    return close[0] if close else closest


def _end_of(points: np.ndarray, length_m: float) -> np.ndarray:
    """Return the last part of a line."""
    s = arc_lengths(points)
    return part_of(points, s, max(s[-1] - length_m, 0.0), s[-1])


def without_bends(lanes: Sequence[RoadLane], findings: Findings) -> list[RoadLane]:
    """Return lanes without the connections that no car can drive; add the places of all bends.

    A lane that is bent so itself remains.
    """
    known = {lane.id: lane for lane in lanes if lane.kind == DRIVING}
    refused = set()
    for lane in (lane for lane in known.values() if not lane.junction):
        for place_m in lane.at(np.array(drivable_line(lane.points_m, ()).lost_m[:1])):
            _add_bend(findings, lane.id, place_m)
        for name in lane.successors:
            through = list(_through(known, name))
            if through and not _is_drivable(lane, through):
                refused.add((lane.id, name))
                _add_bend(findings, f"{lane.id} to {through[-1].id}", lane.points_m[-1])
    return [
        replace(
            lane,
            successors=tuple(name for name in lane.successors if (lane.id, name) not in refused),
            predecessors=tuple(
                name for name in lane.predecessors if (name, lane.id) not in refused
            ),
        )
        for lane in lanes
    ]


def _add_bend(findings: Findings, text: str, place_m: np.ndarray) -> None:
    x_m, y_m = place_m.tolist()
    text = f"{text} at ({x_m:.0f}, {y_m:.0f})"
    findings.add("bends that no car can drive", text, (x_m, y_m))


def _through(lanes: Mapping[str, RoadLane], name: str) -> Iterator[RoadLane]:
    """Return the lanes from a lane in a junction to the first lane behind the junction."""
    while name in lanes:
        yield lanes[name]
        name = lanes[name].successors[0] if lanes[name].junction and lanes[name].successors else ""


def _is_drivable(lane: RoadLane, through: list[RoadLane]) -> bool:
    """Return whether a car can drive from a lane over others, straight before and behind them."""
    lines = [part.points_m for part in (lane, *through)]
    start_m = lines[0][0] - _AROUND_M * _direction(lines[0][:2])
    end_m = lines[-1][-1] + _AROUND_M * _direction(lines[-1][-2:])
    points = np.vstack([start_m, *lines, end_m])
    s = arc_lengths(points)
    firsts = 1 + np.cumsum([len(line) for line in lines[:-1]])
    begin, end = s[firsts[0] - 1], s[firsts[-1]]
    lost_m = drivable_line(points, s[[*firsts, *(firsts - 1)]]).lost_m
    return not any(begin - _CHORD_M <= place_m <= end + _CHORD_M for place_m in lost_m)


def joint(before: np.ndarray, after: np.ndarray, lines: Iterable[np.ndarray]) -> np.ndarray:
    """Return the first of some lines that joins two lanes, else a curve (N, 3) between them [m].

    A line is moved to the ends of the lanes, and joins them if it has no sharp bend then.

    Args:
        before: (M, 3) points of the lane before it [m]
        after: (K, 3) points of the lane after it [m]
        lines: (L, 3) points of each line [m]
    """
    tail, head = _end_of(before, _NEAR_M), _end_of(after[::-1], _NEAR_M)[::-1]
    start, end = tail[-1], head[0]
    for line in lines:
        s = arc_lengths(line)
        if min(s[-1], np.hypot(*(end - start)[:2])) < _SHORTEST_M:
            continue
        along = (s / s[-1])[:, None]
        line = line + (1.0 - along) * (start - line[0]) + along * (end - line[-1])
        whole = np.vstack([tail, line, head])
        s = arc_lengths(whole)
        turns = turns_rad(whole, s, np.arange(_STEP_M, s[-1] - _STEP_M, _STEP_M), _STEP_M)
        if turns.max(initial=0.0) < _BENT_RAD:
            return line
    return _curve(tail, head)


def _curve(tail: np.ndarray, head: np.ndarray) -> np.ndarray:
    """Return the cubic Hermite spline (N, 3) from the end of a line to the start of another [m].

    Between the ends of an arc, it is nearly that arc.
    """
    start, end = tail[-1], head[0]
    leave, arrive = _direction(tail), _direction(head)
    half_cos = np.sqrt(np.clip(0.5 + 0.5 * (leave[:2] @ arrive[:2]), 0.0, 1.0))
    tangent_m = np.hypot(*(end - start)[:2]) * 2.0 / (1.0 + half_cos)
    spline = CubicHermiteSpline([0.0, 1.0], [start, end], [tangent_m * leave, tangent_m * arrive])
    return spline(np.linspace(0.0, 1.0, int(tangent_m / _STEP_M) + 2))


def _direction(points_m: np.ndarray) -> np.ndarray:
    step = points_m[-1] - points_m[0]
    return step / max(float(np.hypot(*step[:2])), 1e-9)
