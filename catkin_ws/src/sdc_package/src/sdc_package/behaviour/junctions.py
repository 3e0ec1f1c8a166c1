"""Who else needs the space of a junction, when, and who goes first there."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from sdc_map.crossings import BESIDE_M, OVER_M, Conflict, Crossing
from sdc_package.behaviour.predict import TIMES_S, Predictor, may_travel, reaching, times_at
from sdc_package.behaviour.scene import AT_REST_MPS, StreetScene


class Claim(NamedTuple):
    """A road user that does not give way, on a way that meets that of the car in a junction."""

    number: int  # index of the road user in the observation
    crossing: Crossing
    conflict: Conflict
    room_m: float  # distance of its front to the junction, negative inside [m]


def claims_of(scene: StreetScene, predictor: Predictor) -> tuple[list[Claim], dict[int, float]]:
    """Return who does not give way to the car in the next junctions, and who does.

    Returns:
        the claims where the car can still stop, and how far from each that gives way, by its
        index, it stops [m]
    """
    found: list[Claim] = []
    stops_m: dict[int, float] = {}
    for crossing in scene.crossings:
        can_stop = crossing.last_stop_m(scene.settings.front_m) > scene.s_m
        for number, user in reaching(scene, crossing.line_m):
            place, rests = predictor.place_of(user), user.speed_mps < AT_REST_MPS
            if place is None or (rests and scene.has_waited) or scene.is_ahead[number]:
                continue
            stopping_m = user.speed_mps**2 / (2.0 * scene.settings.prediction.yields_mps2)
            for conflict in crossing.conflicts:
                away_m = conflict.away_m(predictor.network, place)
                if away_m is None:
                    continue
                room_m = away_m - 0.5 * user.length_m
                # One at rest elsewhere than at its line is in a queue, or was let in.
                if rests and not 0.0 <= room_m < scene.settings.proposals.wait_m:
                    continue
                # One that would have to brake hard does not give way.
                yields = not conflict.is_first and (rests or room_m >= stopping_m)
                if yields and away_m > 0.0:
                    stops_m[number] = max(room_m, 0.0)
                elif not yields and can_stop:
                    found.append(Claim(number, crossing, conflict, room_m))
    return found, stops_m


def taken_s(scene: StreetScene, s_m: np.ndarray, claims: Sequence[Claim]) -> np.ndarray:
    """Return (C, P) for how long the car takes the right of way of each road user [s].

    It is the mean of all that the road user may do: for how long both are in the space of the
    junction that both need, or within `clear_s` of it; or, where the road user arrives at the
    junction soon after the car enters it, how much too soon. `s_m` are the arc lengths (T, P) of
    the car's centre on the proposals [m].
    """
    if not claims:
        return np.zeros((0, s_m.shape[1]))
    margins, front_m = scene.settings.streets, scene.settings.front_m
    own_m, its_s, weights, rules = [], [], [], []
    for number, crossing, conflict, room_m in claims:
        user, line_m = scene.obstacles[number], crossing.line_m - front_m
        (first_m, last_m), (its_first_m, its_last_m) = conflict.own_m, conflict.its_m
        own_m.append((first_m - BESIDE_M - front_m, last_m + front_m, line_m))
        rules.append((conflict.merges, conflict.is_first and line_m + OVER_M > scene.s_m))
        its_m = room_m + np.array([0.0, its_first_m, its_last_m + user.length_m])
        likely, ways_m = may_travel(scene, user)
        weights.append(likely)
        its_s.append([times_at(its_m, way_m) for way_m in ways_m])
    # The times of the car are (C, 1, P), those of the things that each may do (C, K, 1).
    enters_s, leaves_s, begins_s = np.array([times_at(own_m, way) for way in s_m.T]).T[:, :, None]
    arrives_s, in_s, out_s = np.moveaxis(its_s, -1, 0)[..., None]
    merges, is_first = np.array(rules).T[..., None, None]
    until_s = np.where(merges, enters_s + margins.clear_s, math.inf)  # behind the car, it follows
    leaves_s = np.minimum(np.minimum(leaves_s, TIMES_S[-1]), until_s)
    before_s = leaves_s - (in_s - margins.clear_s)  # the car has left by then
    after_s = np.minimum(out_s, TIMES_S[-1]) + margins.clear_s - enters_s  # it enters after
    comes = np.isfinite(arrives_s)
    soon_s = begins_s + margins.arrives_s - np.where(comes, arrives_s, 0.0)
    soon_s = np.where(is_first & (begins_s < out_s), soon_s, 0.0)
    taken = np.clip(np.maximum(np.minimum(before_s, after_s), soon_s), 0.0, margins.arrives_s)
    total_s = (np.array(weights)[..., None] * comes * taken).sum(axis=1)
    return np.where(np.isfinite(enters_s[:, 0]), total_s, 0.0)
