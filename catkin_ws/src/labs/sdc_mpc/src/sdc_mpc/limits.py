"""The limits of a plan: of its inputs, and of their changes from tick to tick."""

from __future__ import annotations

import numpy as np


def limits(
    least: np.ndarray, most: np.ndarray, change: np.ndarray, last: np.ndarray, ticks: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return lower and upper limits (4 n,): first of all inputs, then of their `changes`.

    Args:
        least: (2,) least inputs
        most: (2,) greatest inputs
        change: (2,) greatest change of each input in a tick
        last: (2,) the last command
        ticks: number n of ticks
    """
    # TODO 6: lower and upper (until then: return np.full(4 * ticks, -9.0), np.full(4 * ticks, 9.0))
    lower = np.concatenate([np.tile(least, ticks), np.tile(-change, ticks)])
    upper = np.concatenate([np.tile(most, ticks), np.tile(change, ticks)])
    lower[2 * ticks : 2 * ticks + 2] += last
    upper[2 * ticks : 2 * ticks + 2] += last
    return lower, upper
    # ----------------------------------------------------------------------------
