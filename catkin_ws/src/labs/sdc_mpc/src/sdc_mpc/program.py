"""The quadratic program of a plan: its cost and its constraints.

A plan of n ticks has 5 n unknowns: first the states z after each tick (cross-track error, heading
error, speed), then the inputs u in each tick (wheel angle, acceleration). The solver minimizes
0.5 x' p x + q' x over x = (z1, ..., zn, u0, ..., u(n - 1)).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import block_diag


def changes(ticks: int) -> np.ndarray:
    """Return the matrix (2 n, 2 n) that makes changes of the inputs from the inputs.

    The first change of each input lacks the last command, which is no unknown.
    """
    return np.eye(2 * ticks) - np.eye(2 * ticks, k=-2)


def cost(
    weights: np.ndarray, change_weights: np.ndarray, references: np.ndarray, last: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return p (5 n, 5 n) and q (5 n,).

    Half of: each state's squared difference to its reference, times its weight, and each squared
    change of an input, times its weight.

    Args:
        weights: (3,) of the states
        change_weights: (2,) of the changes of the inputs
        references: (n, 3) of the states
        last: (2,) the last command
    """
    ticks = len(references)
    # TODO 4: p and q (until then: return np.eye(5 * ticks), np.zeros(5 * ticks))
    difference = changes(ticks)
    of_changes = difference.T @ np.diag(np.tile(change_weights, ticks)) @ difference
    p = block_diag(np.diag(np.tile(weights, ticks)), of_changes)
    q = np.concatenate([-(weights * references).ravel(), np.zeros(2 * ticks)])
    q[3 * ticks : 3 * ticks + 2] = -change_weights * last
    return p, q
    # ----------------------------------------------------------------------------


def dynamics(
    ad: np.ndarray, bd: np.ndarray, start: np.ndarray, bends: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return rows (3 n, 5 n) and right (3 n,) with rows x = right where the plan obeys the model.

    The model is z after = ad z + bd (u - bend): only a wheel angle beyond that of the bend turns
    the car off the path. In the rows, z after has the sign +.

    Args:
        ad: (3, 3)
        bd: (3, 2)
        start: (3,) state at the start of the plan
        bends: (n, 2) inputs that keep the car on the path in each tick
    """
    ticks = len(bends)
    # TODO 5: rows and right (until then: return np.zeros((0, 5 * ticks)), np.zeros(0))
    of_states = np.eye(3 * ticks) - np.kron(np.eye(ticks, k=-1), ad)
    of_inputs = np.kron(np.eye(ticks), bd)
    right = -of_inputs @ bends.ravel()
    right[:3] += ad @ start
    return np.hstack([of_states, -of_inputs]), right
    # ----------------------------------------------------------------------------
