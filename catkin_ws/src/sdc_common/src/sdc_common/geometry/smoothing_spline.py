"""A spline near noisy points, as smooth as their noise allows."""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import solveh_banded
from scipy.sparse import csr_matrix, diags

# Distance between the knots, and the least width of the smoothing.
_KNOT_M = 1.0
_MIN_WIDTH_M = 1.0
# Where the mean deviation of the points over two widths exceeds so many standard errors, the spline
# cuts a bend: there the width is reduced by this factor, and the spline is fitted again.
_SIGNIFICANT = 3.5
_REDUCTION = 0.8
_MAX_FITS = 14
_THIRD_DIFFERENCE = (-1.0, 3.0, -3.0, 1.0)


class SmoothingSpline:
    """A cubic spline that minimizes the deviation of points plus the change of its curvature.

    Straights, arcs and clothoids change their curvature least. The spline minimizes the integral of
    deviation^2 + width^6 * (third derivative)^2. The width is reduced where the points deviate to
    one side by more than their noise explains.

    Reference: P. Eilers and B. Marx, Flexible Smoothing with B-splines and Penalties, Statistical
    Science 11(2), 1996.
    """

    def __init__(
        self,
        s_m: np.ndarray,
        points_m: np.ndarray,
        spacing_m: float,
        noise_m: float,
        width_m: float,
    ):
        """Fit the spline.

        Args:
            s_m: (N,) ascending parameters of the points, about their arc lengths [m]
            points_m: (N, 2) points [m]
            spacing_m: usual distance between the points [m]
            noise_m: standard deviation of the points [m]
            width_m: greatest width of the smoothing [m]
        """
        self._start_m = float(s_m[0])
        self._count = max(1, math.ceil((float(s_m[-1]) - self._start_m) / _KNOT_M))
        basis = self._basis(s_m)
        # Differences from the middle keep the digits of large coordinates.
        self._middle_m = points_m.mean(axis=0)
        right = spacing_m * (basis.T @ (points_m - self._middle_m))
        differences = diags(_THIRD_DIFFERENCE, range(4), (self._count, self._count + 3))
        data = spacing_m * (basis.T @ basis)
        widths_m = np.full(self._count, max(width_m, _MIN_WIDTH_M))
        for _ in range(_MAX_FITS):
            penalty = diags(widths_m**6 / _KNOT_M**5) @ differences
            matrix = data + differences.T @ penalty
            bands = [np.pad(matrix.diagonal(offset), (offset, 0)) for offset in (3, 2, 1, 0)]
            self._coefficients = solveh_banded(bands, right)
            fitted_m = self._middle_m + basis @ self._coefficients
            biased = self._biased(s_m, points_m - fitted_m, noise_m, widths_m)
            biased &= widths_m > _MIN_WIDTH_M
            if not biased.any():
                break
            widths_m = np.maximum(np.where(biased, _REDUCTION, 1.0) * widths_m, _MIN_WIDTH_M)
        self.widths_m = widths_m

    def __call__(self, s_m: np.ndarray) -> np.ndarray:
        """Return the points (M, 2) of the spline at parameters (M,) [m]."""
        return self._middle_m + self._basis(s_m) @ self._coefficients

    def _basis(self, s_m: np.ndarray) -> csr_matrix:
        """Return the values of the cubic B-splines (columns) at parameters (rows) [m]."""
        position = (s_m - self._start_m) / _KNOT_M
        first = np.clip(position.astype(int), 0, self._count - 1)
        t = position - first
        u = 1.0 - t
        middle = 4.0 - 6.0 * t * t + 3.0 * t**3, 4.0 - 6.0 * u * u + 3.0 * u**3
        values = np.column_stack([u**3, *middle, t**3]) / 6.0
        columns = first[:, None] + np.arange(4)  # of the four that are not 0
        ends = 4 * np.arange(len(first) + 1)
        return csr_matrix((values.ravel(), columns.ravel(), ends), (len(first), self._count + 3))

    def _biased(
        self, s_m: np.ndarray, deviations_m: np.ndarray, noise_m: float, widths_m: np.ndarray
    ) -> np.ndarray:
        """Return the mask of the intervals where the points deviate to one side."""
        middles_m = self._start_m + _KNOT_M * (np.arange(self._count) + 0.5)
        low = np.searchsorted(s_m, middles_m - widths_m)
        high = np.searchsorted(s_m, middles_m + widths_m)
        sums = np.vstack([np.zeros(2), np.cumsum(deviations_m, axis=0)])
        excess = np.abs(sums[high] - sums[low]).max(axis=1)
        significant = excess > _SIGNIFICANT * noise_m * np.sqrt(np.maximum(high - low, 1))
        reach = np.ceil(widths_m / _KNOT_M).astype(int)
        rows = np.flatnonzero(significant)
        marks = np.zeros(self._count + 1, int)
        np.add.at(marks, np.maximum(rows - reach[rows], 0), 1)
        np.add.at(marks, np.minimum(rows + reach[rows] + 1, self._count), -1)
        return np.cumsum(marks)[:-1] > 0
