"""The lane in a single picture: which markings are on its lines, and which lane has the most.

The centre of a lane is at y = -offset + heading x + curvature x^2 / 2 in the vehicle frame.
"""

from __future__ import annotations

import numpy as np

INLIER_M = 0.12


def distances_to_lines(lanes: np.ndarray, points_m: np.ndarray, lines_m: np.ndarray) -> np.ndarray:
    """Return how far points are to the left of the lines of lanes (L, N, 3) [m].

    Args:
        lanes: lanes (L, 3): offset of the car to the left of the lane's centre [m], direction of
            the lane minus heading of the car [rad], curvature [1/m]
        points_m: points (N, 2) in the vehicle frame [m]
        lines_m: offsets (3,) of right edge, dashes and left edge to the left of the centre [m]
    """
    offset, heading, curvature = lanes[:, :1], lanes[:, 1:2], lanes[:, 2:]
    x, y = points_m[:, 0], points_m[:, 1]
    # TODO 4: from each line (until then: return np.full((len(lanes), len(x), 3), 9.0))
    return np.full((len(lanes), len(x), 3), 9.0)
    # ----------------------------------------------------------------------------


def are_inliers(lanes: np.ndarray, points_m: np.ndarray, lines_m: np.ndarray) -> np.ndarray:
    """Return which points lie on which lines of which lanes (L, N, 3)."""
    return np.abs(distances_to_lines(lanes, points_m, lines_m)) < INLIER_M


def best_lane(lanes: np.ndarray, points_m: np.ndarray, lines_m: np.ndarray) -> np.ndarray:
    """Return the lane (3,) whose lines pass through most of the points.

    The arguments are those of `distances_to_lines`.

    Reference: M. A. Fischler and R. C. Bolles, Random Sample Consensus, Communications of the ACM
    24(6), 1981.
    """
    # TODO 5: count the points on one of the lines of each lane (until then: return lanes[0])
    return lanes[0]
    # ----------------------------------------------------------------------------
