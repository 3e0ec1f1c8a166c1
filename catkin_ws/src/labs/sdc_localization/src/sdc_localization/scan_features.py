"""Find poles and corners of buildings in a scan of the planar lidar."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

# Neighbouring points of one surface are at most so far apart: a step, and a share of the range.
_STEP_M = 0.3
_STEP_SHARE = 0.03
_WIDEST_POLE_M = 0.6
_FREE_M = 0.5
# Two beams with nothing between them; they are a quarter of a degree apart.
_NEXT_RAD = math.radians(0.4)
_FEWEST_POLE_POINTS = 3
_FEWEST_SIDE_POINTS = 8
_SHORTEST_SIDE_M = 1.5
_LARGEST_MISFIT_M = 0.06
# Two walls of a house meet at about a right angle.
_LARGEST_COSINE = 0.3


def scan_points(cloud: Any) -> np.ndarray:
    """Return x and y (N, 2) of the points of a sensor_msgs/PointCloud2.

    Raises:
        ValueError: it has no x and y at its beginning, or its size is wrong
    """
    if [(field.name, field.offset, field.datatype) for field in cloud.fields[:2]] != [
        ("x", 0, 7),
        ("y", 4, 7),
    ]:
        raise ValueError("a scan whose first fields are not x and y as 32-bit numbers")
    rows = np.frombuffer(cloud.data, np.uint8).reshape(-1, cloud.point_step)
    return np.ascontiguousarray(rows[:, :8]).view(np.float32).astype(float)


def find_features(points_m: np.ndarray, pole_radius_m: float) -> np.ndarray:
    """Return the centres of poles and the corners of buildings (M, 2) in the frame of the lidar.

    Args:
        points_m: (N, 2) points in the order of their angles
        pole_radius_m: radius of a pole
    """
    if len(points_m) < _FEWEST_POLE_POINTS:
        return np.zeros((0, 2))
    ranges, angles = np.hypot(*points_m.T), np.arctan2(points_m[:, 1], points_m[:, 0])
    gaps = np.hypot(*np.diff(points_m, axis=0).T)
    breaks = np.flatnonzero(gaps > _STEP_M + _STEP_SHARE * ranges[:-1]) + 1
    found = []
    starts, ends = np.append(0, breaks), np.append(breaks, len(points_m))
    for start, end in zip(starts.tolist(), ends.tolist()):
        surface = points_m[start:end]
        if len(surface) < _FEWEST_POLE_POINTS:
            continue
        width = math.dist(surface[0], surface[-1])
        if width < _WIDEST_POLE_M:
            if _is_free(ranges, angles, start, end):
                found.append(_pole(surface, pole_radius_m))
        elif len(surface) >= 2 * _FEWEST_SIDE_POINTS:
            corner = _corner(surface)
            if corner is not None:
                found.append(corner)
    return np.array(found).reshape(-1, 2)


def _is_free(ranges: np.ndarray, angles: np.ndarray, start: int, end: int) -> bool:
    """Return whether nothing in front of the surface, in the next beam, hides a part of it."""

    def hides(other: int, own: int) -> bool:
        is_next = 0 <= other < len(ranges) and abs(angles[other] - angles[own]) < _NEXT_RAD
        return is_next and ranges[other] < ranges[own] + _FREE_M

    return not hides(start - 1, start) and not hides(end, end - 1)


def _pole(surface: np.ndarray, radius_m: float) -> np.ndarray:
    """Return the centre: the nearest point is one radius in front of it."""
    middle = surface.mean(axis=0)
    direction = middle / np.hypot(*middle)
    return direction * (np.hypot(*surface.T).min() + radius_m)


def _corner(surface: np.ndarray) -> np.ndarray | None:
    """Return where two walls meet, or None without such a place."""
    chord = surface[-1] - surface[0]
    normal = np.array([-chord[1], chord[0]]) / np.hypot(*chord)
    split = int(np.argmax(np.abs((surface - surface[0]) @ normal)))
    sides = surface[: split + 1], surface[split:]
    lines = []
    for side in sides:
        if len(side) < _FEWEST_SIDE_POINTS or math.dist(side[0], side[-1]) < _SHORTEST_SIDE_M:
            return None
        middle = side.mean(axis=0)
        _, sizes, axes = np.linalg.svd(side - middle, full_matrices=False)
        if sizes[1] / math.sqrt(len(side)) > _LARGEST_MISFIT_M:
            return None
        lines.append((middle, axes[0]))
    (a, along_a), (b, along_b) = lines
    if abs(along_a @ along_b) > _LARGEST_COSINE:
        return None
    steps = np.linalg.solve(np.column_stack([along_a, -along_b]), b - a)
    return a + steps[0] * along_a
