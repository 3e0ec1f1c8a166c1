"""OSQP, which solves a quadratic program."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from sdc_common.configuration import how_to_install

try:
    import osqp
except ImportError as error:
    raise ImportError(f"osqp is not installed; {how_to_install('mpc')}") from error


def solution(
    p: np.ndarray, q: np.ndarray, rows: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """Return the x that minimizes 0.5 x' p x + q' x with lower <= rows x <= upper.

    Raises:
        ValueError: there is none
    """
    if not np.all(lower <= upper):
        raise ValueError("a lower limit is greater than its upper limit")
    solver = osqp.OSQP()
    solver.setup(
        sparse.csc_matrix(np.triu(p)), q, sparse.csc_matrix(rows), lower, upper,
        verbose=False, eps_abs=1e-5, eps_rel=1e-5, adaptive_rho_interval=50,
    )  # fmt: skip
    found = solver.solve(raise_error=False)
    if found.x is None or not np.isfinite(found.x).all():
        raise ValueError(f"the program has no solution: {found.info.status}")
    return found.x
