"""Who else needs the space of a junction, when, and who goes first there."""

from __future__ import annotations

import math
from typing import NamedTuple

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


def taken_s(scene: StreetScene, s_m: np.ndarray, claim: Claim) -> np.ndarray:
    """Return (P,) for how long the car takes the right of way of a road user [s].

    It is the mean of all that the road user may do: for how long both are in the space of the
    junction that both need, or within `clear_s` of it; or, where the road user arrives at the
    junction soon after the car enters it, how much too soon. `s_m` are the arc lengths (T, P) of
    the car's centre on the proposals [m].
    """
    margins, front_m = scene.settings.streets, scene.settings.front_m
    user, conflict = scene.obstacles[claim.number], claim.conflict
    line_m = claim.crossing.line_m - front_m
    first_m, last_m = conflict.own_m
    places_m = first_m - BESIDE_M - front_m, last_m + front_m, line_m
    enters_s, leaves_s, begins_s = np.array([times_at(places_m, way_m) for way_m in s_m.T]).T
    leaves_s = np.minimum(leaves_s, TIMES_S[-1])
    if conflict.merges:  # behind the car, it follows
        leaves_s = np.minimum(leaves_s, enters_s + margins.clear_s)
    outside = line_m + OVER_M > scene.s_m
    total_s, (its_first_m, its_last_m) = np.zeros_like(enters_s), conflict.its_m
    its_places_m = claim.room_m + np.array([0.0, its_first_m, its_last_m + user.length_m])
    for weight, travel_m in may_travel(scene, user):
        arrives_s, in_s, out_s = times_at(its_places_m, travel_m)
        if math.isinf(arrives_s):
            continue
        before_s = leaves_s - (in_s - margins.clear_s)  # the car has left by then
        after_s = min(out_s, TIMES_S[-1]) + margins.clear_s - enters_s  # it enters after
        taken = np.minimum(before_s, after_s)
        if outside and conflict.is_first:
            soon_s = begins_s + margins.arrives_s - arrives_s
            taken = np.maximum(taken, np.where(begins_s < out_s, soon_s, 0.0))
        total_s += weight * np.clip(taken, 0.0, margins.arrives_s)
    return np.where(np.isfinite(enters_s), total_s, 0.0)
