"""A route: a long polyline with smoothed heading and curvature."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from sdc_common.geometry.polyline import Place, Polyline

# Heading and curvature are estimated on samples of this spacing, smoothed by a Gaussian of this
# standard deviation. The points of a recorded route are about 1 m apart, and the tightest bend of a
# town (4 m radius) is about 6 m long: the window must cover several points, but no whole bend.
_SAMPLE_M = 0.5
_SIGMA_M = 1.0
# Places on the route that are this far apart along it belong to different passes.
_PASS_GAP_M = 5.0
# Passes whose distances to a point differ by less are equally near.
_EQUALLY_NEAR_M = 1.0


def checked_points(points_m: np.ndarray) -> np.ndarray:
    """Return a copy of the points of a route as an (N, 2) array of floats [m].

    Raises:
        ValueError: there are fewer than 2 points, the shape is not (N, 2), a number is not finite,
            or a point repeats the one before it
    """
    points = np.array(points_m, dtype=float)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise ValueError(
            f"a route needs at least 2 points of x and y, got an array of shape {points.shape}"
        )
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        raise ValueError(f"point {int(np.argmin(finite))} of the route is not finite")
    repeats = (np.diff(points, axis=0) == 0.0).all(axis=1)
    if repeats.any():
        raise ValueError(f"points {int(np.argmax(repeats))} and the next of the route coincide")
    return points


def smoothed_heading_and_curvature(
    points_m: np.ndarray, s_m: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return heading and curvature of a polyline that is smoothed by a Gaussian.

    Smoothing keeps the noise of a recorded route from becoming bends.

    Returns:
        (N,) continuous headings at the (N, 2) points, not wrapped [rad], and (N,) curvatures,
        positive to the left [1/m]

    Reference: F. Mokhtarian and A. Mackworth, IEEE Trans. PAMI 8(1), 1986, section III.
    """
    length = float(s_m[-1])
    count = max(2, int(round(length / _SAMPLE_M)) + 1)
    s, step = np.linspace(0.0, length, count, retstep=True)
    xy = interpolate(s, s_m, points_m)
    # Mirror the line in its end points: its smoothed continuation is straight.
    reach = min(int(math.ceil(4.0 * _SIGMA_M / step)), count - 1)
    xy = np.vstack([2.0 * xy[0] - xy[reach:0:-1], xy, 2.0 * xy[-1] - xy[-2 : -2 - reach : -1]])
    sigma = min(_SIGMA_M, 0.25 * length) / step
    smooth = gaussian_filter1d(xy, sigma, axis=0, mode="nearest")
    first = np.gradient(smooth, step, axis=0)
    second = np.gradient(first, step, axis=0)[reach : reach + count]
    first = first[reach : reach + count]
    heading = np.unwrap(np.arctan2(first[:, 1], first[:, 0]))
    speed = np.maximum(np.hypot(first[:, 0], first[:, 1]), 1e-6)
    curvature = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / speed**3
    return np.interp(s_m, s, heading), np.interp(s_m, s, curvature)


def interpolate(at_s_m: np.ndarray, s_m: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the rows (M, K) of `values` (N, K) at arc lengths, linear between `s_m` (N,)."""
    return np.column_stack([np.interp(at_s_m, s_m, column) for column in values.T])


def smooth_step(s_m: np.ndarray, begin_m: float, length_m: float) -> np.ndarray:
    """Return the smooth step from 0 to 1 over a stretch, at arc lengths (N,)."""
    t = np.clip((s_m - begin_m) / length_m, 0.0, 1.0)
    return t**3 * (10.0 - 15.0 * t + 6.0 * t * t)


class Route:
    """An open polyline of any length with smoothed heading and curvature."""

    def __init__(self, points_m: np.ndarray):
        """Compute the geometry of (N, 2) points.

        Raises:
            ValueError: `checked_points` refuses the points
        """
        self.points = checked_points(points_m)
        # The same points and headings as a Polyline that ends at its end points
        self.line = Polyline(self.points.tolist(), extend=False)
        self.s = np.array(self.line.s)  # (N,) arc lengths at the points [m]
        # (N,) continuous headings, not wrapped [rad]; curvatures, positive to the left [1/m]
        self.heading, self.curvature = smoothed_heading_and_curvature(self.points, self.s)
        self.line.set_headings(self.heading.tolist())
        self._tree: cKDTree | None = None

    @property
    def length_m(self) -> float:
        """Return the arc length of the whole route [m]."""
        return self.line.s[-1]

    def locate(self, x_m: float, y_m: float, yaw_rad: float | None = None) -> Place:
        """Return the place nearest to a point on the whole route, found with a KD-tree.

        Where several passes of the route are about equally near, prefer one in the direction of
        `yaw_rad`, the heading of the vehicle if known, then the earliest.
        """
        if self._tree is None:
            self._tree = cKDTree(self.points)
        nearest, _ = self._tree.query((x_m, y_m))
        candidates = np.sort(self._tree.query_ball_point((x_m, y_m), nearest + _EQUALLY_NEAR_M))
        if yaw_rad is not None:
            along = candidates[np.cos(self.heading[candidates] - yaw_rad) > 0.0]
            candidates = along if len(along) else candidates
        gaps = np.flatnonzero(np.diff(self.s[candidates]) > _PASS_GAP_M)
        first_pass = np.split(candidates, gaps + 1)[0]
        point = int(first_pass[np.argmin(np.hypot(*(self.points[first_pass] - (x_m, y_m)).T))])
        return self.line.nearest(x_m, y_m, max(0, point - 1), point + 1)

    def last_point_s(self, until_s_m: float) -> float:
        """Return the arc length of the last point up to an arc length, at least 0 [m]."""
        return float(self.s[max(0, int(np.searchsorted(self.s, until_s_m, side="right")) - 1)])
