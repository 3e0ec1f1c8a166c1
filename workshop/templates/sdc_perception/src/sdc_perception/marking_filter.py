"""What counts as a marking: as wide as one, and brighter than the asphalt on both sides."""

from __future__ import annotations

import numpy as np

MARKING_M = 0.15
_BRIGHTER = 1.25


def are_markings(
    width_m: np.ndarray, inside: np.ndarray, left: np.ndarray, right: np.ndarray
) -> np.ndarray:
    """Return which neighbouring edges in a row of the picture are the edges of a marking (N,).

    Args:
        width_m: distances (N,) between the two edges on the ground [m]
        inside: brightness (N,) between them, 0..255
        left: brightness (N,) to the left of them
        right: brightness (N,) to the right of them
    """
    # TODO 3: half to twice as wide as MARKING_M, and brighter (until then: return width_m < 0.0)
    return width_m < 0.0
    # ----------------------------------------------------------------------------


def ridge(left: np.ndarray, centre: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return how much brighter a place is than both sides of it.

    Args:
        left: mean brightness (N, M) of a box to the left of each place
        centre: mean brightness (N, M) of a box at each place
        right: mean brightness (N, M) of a box to the right of each place

    Reference: T. Veit, J.-P. Tarel, P. Nicolle and P. Charbonnier, Evaluation of Road Marking
    Feature Extraction, ITSC 2008: the filter with symmetric local thresholds.
    """
    # TODO 6: brighter than the brighter side (until then: difference = np.zeros_like(centre))
    difference = np.zeros_like(centre)
    # ----------------------------------------------------------------------------
    # Black beyond the border of the picture is no side of a marking.
    difference[np.minimum(left, right) <= 0.0] = 0.0
    return difference
