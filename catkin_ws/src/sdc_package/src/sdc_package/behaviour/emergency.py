"""Finds contacts that a firm stop no longer avoids, as emergency braking by UN Regulation 152."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.route import Route
from sdc_package.braking import HARD_MPS2
from sdc_package.obstacle_prediction import Obstacles

# Contacts are looked for at these times [s]. Those matter that come so near meanwhile [m]. The car
# brakes after a time [s].
_LAST_S, _NEAR_M, _REACTS_S = 1.5, 12.0, 0.2
_TIMES_S = np.arange(0.1, _LAST_S + 0.05, 0.1)
# Age of the means of speed and heading, and what a new value with weight 0.2 leaves of it [s].
_MEAN_S, _KEPT_S = 0.2, 0.16
# The greatest acceleration and deceleration with which others are expected to go on [m/s^2].
_FASTER_MPS2, _SLOWER_MPS2 = 4.0, 7.0
# Points of a body in shares of its length and its width.
_ALONG, _ACROSS = np.array([(m / 8.0, n / 4.0) for m in range(-4, 5) for n in range(-2, 3)]).T


class Motions:
    """How speed and heading of the road users change, by their ids; without an id, they do not."""

    def __init__(self):
        self._means: dict[int, tuple[float, float]] = {}

    def update(self, obstacles: Obstacles) -> None:
        """Look at the road users; call it once in each plan."""
        changes = [(one, *self.changes(one)) for one in obstacles if one.id]
        self._means = {
            one.id: (one.speed_mps - _KEPT_S * faster, one.yaw_rad - _KEPT_S * turn)
            for one, faster, turn in changes
        }

    def changes(self, one: DetectedObstacle) -> tuple[float, float]:
        """Return acceleration and rate of turn [m/s^2, rad/s]."""
        mps, yaw = self._means.get(one.id, (one.speed_mps, one.yaw_rad))
        turned_rad = math.remainder(one.yaw_rad - yaw, 2.0 * math.pi)
        return (one.speed_mps - mps) / _MEAN_S, turned_rad / _MEAN_S

    def near(self, at: Sequence[float], speed_mps: float, obstacles: Obstacles) -> np.ndarray:
        """Return (A, 9) what `meets` needs to know of those near a car with this speed."""
        reach_m = _NEAR_M + _LAST_S * speed_mps
        rows = [
            (n, one.x_m, one.y_m, one.yaw_rad, one.speed_mps, one.length_m, one.width_m)
            + self.changes(one)
            for n, one in enumerate(obstacles)
            if math.dist((one.x_m, one.y_m), at) < reach_m + _LAST_S * one.speed_mps
        ]
        return np.array(rows).reshape(-1, 9)


def meets(
    route: Route,
    offset_m: np.ndarray,
    s_m: float,
    speed_mps: float,
    others: np.ndarray,
    front_m: float,
    half_width_m: float,
) -> np.ndarray:
    """Return (A,) which of the others first meet the front half of the car, which brakes firmly.

    Args:
        route: the route
        offset_m: (N,) distance of the car's way from its points, positive to the left [m]
        s_m: arc length of the car's centre [m]
        speed_mps: its speed [m/s]
        others: (A, 9) number, x, y, heading, speed, length, width, acceleration and rate of turn,
            with which they go on [-, m, m, rad, m/s, m, m, m/s^2, rad/s]
        front_m: distance from the centre of the car to its front [m]
        half_width_m: half of its width [m]
    """
    x, y, yaw, mps, length_m, width_m, faster, turn = others.T[1:, :, None]
    faster = np.clip(faster, -_SLOWER_MPS2, _FASTER_MPS2)
    its_stop_s = np.where(faster < 0.0, mps / np.maximum(-faster, 1e-3), math.inf)
    its_s = np.minimum(_TIMES_S, its_stop_s)
    way_m = mps * its_s + 0.5 * faster * its_s**2
    turned, chord = turn * its_s, yaw + 0.5 * turn * its_s
    brakes_s, stops_s = np.maximum(_TIMES_S - _REACTS_S, 0.0), speed_mps / HARD_MPS2
    mine_s = np.minimum(brakes_s, stops_s)
    ahead_m = s_m + speed_mps * (_TIMES_S - brakes_s + mine_s) - 0.5 * HARD_MPS2 * mine_s**2
    points = route.heading, offset_m, *route.points.T
    heading, offset, line_x, line_y = (np.interp(ahead_m, route.s, one) for one in points)
    c, s = np.cos(heading), np.sin(heading)
    dx = x + way_m * np.cos(chord) - (line_x - offset * s)
    dy = y + way_m * np.sin(chord) - (line_y + offset * c)
    # The points of the others as the car sees them, (A, T, K).
    along, across = (length_m * _ALONG)[:, None], (width_m * _ACROSS)[:, None]
    cos, sin = (one(yaw + turned - heading)[..., None] for one in (np.cos, np.sin))
    ahead = (c * dx + s * dy)[..., None] + cos * along - sin * across
    left = (c * dy - s * dx)[..., None] + sin * along + cos * across
    inside = (np.abs(ahead) < front_m) & (np.abs(left) < half_width_m)
    inside &= (brakes_s < stops_s)[:, None]  # the car moves
    first = np.arange(len(inside)), inside.any(axis=2).argmax(axis=1)
    return (inside[first] & (ahead[first] > 0.0)).any(axis=1)
