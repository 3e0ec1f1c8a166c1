"""Proposed ways of the car, simulated a few seconds ahead among the others.

The car follows whoever is in its way by the intelligent driver model (M. Treiber, A. Hennecke and
D. Helbing, Phys. Rev. E 62, 2000); the others keep their speed and their lane.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sdc_package.behaviour.road import Around

STEP_S, STEPS, _SOON_STEP = 0.4, 26, 1
# Spacing of the places at which ways and speeds are given [m].
GRID_M = 1.0
# Distance to the one ahead at standstill [m], and time to it [s].
_GAP_M, _GAP_S = 3.0, 1.0
_HARDEST_MPS2 = 6.0
# Distances to the side and along the road within which two bodies count as in contact [m], and the
# time that an oncoming one must be away [s].
_SIDE_M, _ALONG_M, _ONCOMING_S = 0.3, 0.5, 1.2
_SIDE_AT_REST_M = 0.1
# One behind the car in the lane that it takes brakes no harder than this [m/s^2].
_REAR_MPS2 = 1.5
# A car at rest is only met by those that come towards it [m/s].
_AT_REST_MPS = 0.3
# Who moves across the road does so for this time [s]; slower motion across is none, nor is a
# smaller share of the speed along it.
_ACROSS_S, _ACROSS_MPS, _ACROSS_SHARE = 1.5, 0.3, 0.07


@dataclass(frozen=True)
class Body:
    """The car.

    Attributes:
        front_m: distance from its centre to its front [m]
        width_m: its width [m]
        acceleration_mps2: its acceleration [m/s^2]
        braking_mps2: its usual deceleration [m/s^2]
    """

    front_m: float
    width_m: float
    acceleration_mps2: float
    braking_mps2: float


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
    count, last = len(ways_m), ways_m.shape[1] - 1
    every = np.arange(count)

    def at(s: np.ndarray) -> np.ndarray:
        return np.clip(((s - from_m) / GRID_M).astype(int), 0, last)

    s, v = np.full(count, s_m), np.full(count, speed_mps)
    side_m = np.where(np.abs(others.along_mps) > _AT_REST_MPS, _SIDE_M, _SIDE_AT_REST_M)
    body_m = others.half_width_m + 0.5 * car.width_m
    half_width_m = body_m + side_m
    half_length_m = others.half_length_m + car.front_m
    least_mps = np.maximum(_ACROSS_MPS, _ACROSS_SHARE * np.abs(others.along_mps))
    across_mps = np.where(np.abs(others.left_mps) > least_mps, others.left_mps, 0.0)
    aligned = others.along_mps > np.abs(others.left_mps)
    oncoming = others.along_mps < -np.abs(others.left_mps)
    near_m = half_length_m + np.where(oncoming, -_ONCOMING_S * margin * others.along_mps, _ALONG_M)
    here = np.abs(others.y_m - ways_m[:, at(s)[0]][:, None]) < half_width_m
    # One behind in the car's lane is responsible for its distance.
    settled = here & aligned & (others.s_m < s_m)
    soon_mps = v
    contact_s, hardest, oncoming_s = np.full(count, np.inf), np.zeros(count), np.zeros(count)
    for step in range(STEPS):
        time_s = step * STEP_S
        its_s = others.s_m + time_s * others.along_mps
        its_y = others.y_m + min(time_s, _ACROSS_S) * across_mps
        distance_m = its_s - s[:, None]
        # On its place along the road, the way of the car passes this far from it.
        beside_m = np.abs(its_y - ways_m[:, at(its_s)])
        in_way = (beside_m < half_width_m) & (distance_m > 0.0)
        gap_m = np.maximum(distance_m - half_length_m, 0.1)
        v_row = v[:, None]
        root = 2.0 * np.sqrt(car.acceleration_mps2 * car.braking_mps2)
        wanted_m = _GAP_M + np.maximum(v_row * (_GAP_S + (v_row - others.along_mps) / root), 0.0)
        push = np.where(in_way, (wanted_m / gap_m) ** 2, 0.0).max(axis=1, initial=0.0)
        room_m = np.maximum(stop_m - s, 0.1)
        push = np.maximum(push, np.where(room_m < 60.0, (v * (0.5 + v / root) / room_m) ** 2, 0.0))
        top = most_mps[every, at(s)]
        free = (v / np.maximum(top, 0.1)) ** 4
        a = np.clip(car.acceleration_mps2 * (1.0 - free - push), -_HARDEST_MPS2, None)
        hardest = np.maximum(hardest, car.acceleration_mps2 * (push - 1.0) * (v > 0.5))
        # Whom the car meets, or cuts in before.
        # Its front is where its centre will be; towards those behind it is the rear that matters.
        front_y, mine_y = (ways_m[every, at(s + far)][:, None] for far in (car.front_m, 0.0))
        away_m = np.abs(its_y - np.where(distance_m > 0.0, front_y, mine_y))
        overlap = away_m < body_m + np.minimum(side_m, _SIDE_AT_REST_M + time_s * _SIDE_M)
        behind = aligned & (distance_m < 0.0)
        gap_m = -distance_m - half_length_m
        closing_mps = np.maximum(others.along_mps - v_row, 0.0)
        safe_m = 1.0 + 0.2 * others.along_mps + closing_mps**2 / (2.0 * _REAR_MPS2)
        cut_in = overlap & behind & ~settled & (gap_m < margin * safe_m)
        settled |= overlap & behind
        met = overlap & (np.abs(distance_m) < near_m) & ~settled
        met &= oncoming | (
            v_row > 0.3
        )  # at rest, the car is hit by those that come towards it only
        oncoming_s += STEP_S * (mine_y[:, 0] > line_m[at(s)])
        bad = (cut_in | met).any(axis=1)
        contact_s = np.where(bad & np.isinf(contact_s), time_s, contact_s)
        v_next = np.minimum(np.maximum(v + STEP_S * a, 0.0), np.maximum(top, v - 2.0))
        s = s + 0.5 * STEP_S * (v + v_next)
        v = v_next
        if step == _SOON_STEP:
            soon_mps = v
    return Forecast(s - s_m, contact_s, hardest, oncoming_s, soon_mps, v)
