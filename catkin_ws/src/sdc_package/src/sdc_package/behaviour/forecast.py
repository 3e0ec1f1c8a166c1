"""Proposed ways of the car, simulated a few seconds ahead among the others.

The car follows who is in its way by the intelligent driver model (M. Treiber, A. Hennecke and
D. Helbing, Phys. Rev. E 62, 2000); the others keep their lane, and their speed or acceleration.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sdc_package.behaviour.road import Around

STEP_S, STEPS, _SOON_STEP = 0.4, 26, 1
SOON_S = STEP_S * (_SOON_STEP + 1)
# Spacing of the places at which ways and speeds are given [m].
GRID_M = 1.0
# Distance to the one ahead at standstill [m], and time to it [s].
_GAP_M, _GAP_S = 3.0, 1.0
_HARDEST_MPS2 = 6.0
# Distances to the side and along the road within which two bodies count as in contact [m], and the
# time that an oncoming one must be away [s].
_SIDE_M, _SIDE_AT_REST_M, _ALONG_M, _ONCOMING_S = 0.3, 0.1, 0.5, 1.2
# The car stays behind one at rest that leaves it a narrower strip, as caution/side_m demands [m].
_FREE_M = 0.4
# Who is behind the car in the lane that it takes brakes so hard [m/s^2], after so many steps.
_REAR_MPS2, _REACTS_STEPS = 2.0, 2
_CUTS_IN_M = 0.3  # a car that moves less to the side does not cut in before one in its lane
# A car at rest is only met by those that come towards it [m/s].
_AT_REST_MPS = 0.3
# Who moves across the road does so for this time [s]; slower motion across is none, nor is a
# smaller share of the speed along it.
_ACROSS_S, _ACROSS_MPS, _ACROSS_SHARE = 1.5, 0.3, 0.07
_FASTER_S = 3.0  # who accelerates does so for this time [s]


@dataclass(frozen=True)
class Body:
    """The car."""

    front_m: float  # distance from its centre to its front [m]
    width_m: float
    acceleration_mps2: float
    braking_mps2: float  # its usual deceleration [m/s^2]


class Forecast(NamedTuple):
    """What becomes of proposals; arrays (P,)."""

    progress_m: np.ndarray  # distance in the simulated time [m]
    contact_s: np.ndarray  # time of the first contact that the car would cause, inf: none [s]
    braking_mps2: np.ndarray  # greatest deceleration for others and stops [m/s^2]
    oncoming_s: np.ndarray  # time on the oncoming lane [s]
    soon_mps: np.ndarray  # speed after the first steps [m/s]
    end_mps: np.ndarray  # speed at the end of the simulated time [m/s]


def forecast(
    ways_m: np.ndarray,
    most_mps: np.ndarray,
    from_m: float,
    s_m: float,
    speed_mps: float,
    others: Around,
    stop_m: np.ndarray,
    margin: np.ndarray,
    car: Body,
    line_m: np.ndarray,
) -> Forecast:
    """Simulate proposals.

    Args:
        ways_m: (P, G) place across the road of each proposal at the places of the grid [m]
        most_mps: (P, G) greatest speed there [m/s]
        from_m: arc length at which the grid begins [m]
        s_m: arc length of the car's centre [m]
        speed_mps: its speed [m/s]
        others: the road users
        stop_m: (P,) where the centre of the car must stop, inf: nowhere [m]
        margin: (P, 1) factor of the distances to oncoming ones, and to those behind
        car: the car
        line_m: (G,) place across the road beyond which the oncoming lane is, inf: none [m]
    """
    rows, last = np.arange(len(ways_m)), ways_m.shape[1] - 1

    def at(s: np.ndarray) -> np.ndarray:
        return np.minimum(np.maximum((s - from_m) / GRID_M, 0).astype(int), last)

    s, v = np.full(len(rows), s_m), np.full(len(rows), speed_mps)
    way_m = ways_m[:, at(s)[:1]]
    judge = _Judge(others, margin, car, s_m, way_m)
    its_way_m = ways_m[rows[:, None], at(judge.its_s)[:, None]]
    in_way = np.abs(judge.its_y - its_way_m) < judge.half_width_m
    contact_s, hardest, oncoming_s = np.full_like(s, np.inf), np.zeros_like(s), np.zeros_like(s)
    for step, its_s in enumerate(judge.its_s):
        here, distance_m = at(s), its_s - s[:, None]
        ahead = in_way[step] & ~judge.settled & (distance_m > 0.0)
        gap_m = np.where(ahead, distance_m - judge.half_length_m, np.inf)
        push = _push(v[:, None], others.along_mps, gap_m, car).max(axis=1, initial=0.0)
        push = np.maximum(push, _push(v, 0.0, stop_m - s + _GAP_M, car))
        hardest = np.maximum(hardest, car.acceleration_mps2 * (push - 1.0) * (v > _AT_REST_MPS))
        # The front is where the centre will be; towards those behind, the rear matters.
        front_y, mine_y = ways_m[rows, at(s + car.front_m), None], ways_m[rows, here, None]
        near_y = np.where(distance_m > -judge.half_length_m, front_y, mine_y)
        cut_in, met = judge.contacts(step, distance_m, near_y, v[:, None])
        cut_in &= ~judge.follows | (np.abs(mine_y - way_m) > _CUTS_IN_M)
        contact_s[(cut_in | met).any(axis=1) & np.isinf(contact_s)] = step * STEP_S
        oncoming_s += STEP_S * (mine_y[:, 0] > line_m[here])
        v_next = _next_mps(v, most_mps[rows, here], push, car)
        s, v = s + 0.5 * STEP_S * (v + v_next), v_next
        if step == _SOON_STEP:
            soon_mps = v
    return Forecast(s - s_m, contact_s, hardest, oncoming_s, soon_mps, v)


def _next_mps(v: np.ndarray, top: np.ndarray, push: np.ndarray, car: Body) -> np.ndarray:
    """Return the speeds after a step, by the intelligent driver model."""
    free = car.acceleration_mps2 * (1.0 - (v / np.maximum(top, 0.1)) ** 4)
    a = np.maximum(free, -car.braking_mps2) - car.acceleration_mps2 * push
    most = np.maximum(top, v - STEP_S * car.braking_mps2)
    return np.minimum(np.maximum(v + STEP_S * np.maximum(a, -_HARDEST_MPS2), 0.0), most)


def _push(v: np.ndarray, ahead_mps: np.ndarray | float, gap_m: np.ndarray, car: Body) -> np.ndarray:
    """Return the interaction of the intelligent driver model with what is ahead."""
    root = 2.0 * math.sqrt(car.acceleration_mps2 * car.braking_mps2)
    wanted_m = _GAP_M + np.maximum(v * (_GAP_S + (v - ahead_mps) / root), 0.0)
    return (wanted_m / np.maximum(gap_m, 0.1)) ** 2


class _Judge:
    """Finds contacts that the car would cause."""

    def __init__(
        self, others: Around, margin: np.ndarray, car: Body, s_m: float, way_m: np.ndarray
    ):
        along_mps, left_mps = others.along_mps, others.left_mps
        self._margin, self._steps = margin, np.zeros((1, 1), int)
        moves = np.abs(along_mps) > _AT_REST_MPS
        side_m = np.where(moves, _SIDE_M, _SIDE_AT_REST_M)
        body_m = others.half_width_m + 0.5 * car.width_m
        self.half_width_m = body_m + np.where(moves, _SIDE_M, _FREE_M)
        self.half_length_m = others.half_length_m + car.front_m
        least_mps = np.maximum(_ACROSS_MPS, _ACROSS_SHARE * np.abs(along_mps))
        self._aligned = along_mps > np.abs(left_mps)
        # One behind sees the car, unless it leaves for another lane.
        behind = self._aligned & (others.s_m < s_m)
        moves_mps = np.where(np.abs(left_mps) > least_mps, left_mps, 0.0)
        leaves = behind & (moves_mps * (way_m - others.y_m) < 0.0)
        across_mps = np.where(behind & ~leaves, 0.0, moves_mps)
        self._oncoming = along_mps < -np.abs(left_mps)
        clear_m = np.where(self._oncoming, -_ONCOMING_S * margin * along_mps, _ALONG_M)
        self._near_m = self.half_length_m + clear_m
        # One behind in the car's lane is responsible for its distance. Here, it does not brake.
        later_m = others.y_m + _ACROSS_S * moves_mps
        self.follows = (np.abs(others.y_m - way_m) < 0.5 * body_m) & behind
        self.settled = self.follows & (np.abs(later_m - way_m) < 0.5 * body_m)
        # For each step, (STEPS, A); the places across the road, (STEPS, P, A).
        time_s = STEP_S * np.arange(STEPS)[:, None]
        faster_s, across_s = np.minimum(time_s, _FASTER_S), np.minimum(time_s, _ACROSS_S)
        self._mps = along_mps + faster_s * others.faster_mps2
        self.its_s = others.s_m + time_s * self._mps - 0.5 * faster_s**2 * others.faster_mps2
        self.its_y = others.y_m + across_s[..., None] * across_mps
        self._reach_m = body_m + np.minimum(side_m, _SIDE_AT_REST_M + time_s * _SIDE_M)

    def contacts(
        self, step: int, distance_m: np.ndarray, way_m: np.ndarray, speed_mps: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return (P, A) whether the car would be too close before one behind, or meets one.

        Distances along the road and places of the car across it are (P, A), its speed is (P, 1).
        """
        overlap = np.abs(self.its_y[step] - way_m) < self._reach_m[step]
        behind, its_mps = overlap & self._aligned & (distance_m < 0.0), self._mps[step]
        closing_mps = np.maximum(its_mps - speed_mps, 0.0)
        safe_m = 1.0 + 0.2 * its_mps + closing_mps**2 / (2.0 * _REAR_MPS2)
        is_close = -distance_m - self.half_length_m < self._margin * safe_m
        cut_in = behind & ~self.settled & is_close
        self._steps = (self._steps + 1) * behind
        self.settled = self.settled | (self._steps > _REACTS_STEPS)
        met = overlap & (np.abs(distance_m) < self._near_m) & ~self.settled
        met &= self._oncoming | (speed_mps > _AT_REST_MPS)
        return cut_in, met
