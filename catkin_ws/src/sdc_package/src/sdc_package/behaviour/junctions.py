"""Who else needs the space of a junction, when, and who goes first there."""

from __future__ import annotations

import math
from typing import Iterator, NamedTuple

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_map.crossings import BESIDE_M, OVER_M, Conflict, Crossing
from sdc_map.network import LanePlace
from sdc_package.behaviour.predict import STEP_S, TIMES_S, Predictor, reaches_s, reaching
from sdc_package.behaviour.road import ALONG_RAD
from sdc_package.behaviour.scene import AT_REST_MPS, StreetScene


class Claim(NamedTuple):
    """A road user on a way that meets that of the car in a junction."""

    number: int  # index of the road user in the observation
    crossing: Crossing
    conflict: Conflict
    away_m: float  # distance of its centre to the junction, negative inside [m]
    room_m: float  # distance of its front to the junction, negative inside [m]
    yields: bool  # whether it gives way to the car


def claims_of(scene: StreetScene, predictor: Predictor) -> list[Claim]:
    """Return the road users on ways that meet that of the car in the next junctions."""
    found: list[Claim] = []
    for crossing in scene.crossings:
        for number, user in reaching(scene, crossing.line_m):
            place = predictor.place_of(user)
            waits = user.speed_mps < AT_REST_MPS
            if place is None or (waits and scene.has_waited) or _is_ahead(scene, user):
                continue
            found += _claims(scene, crossing, number, user, place)
    return found


def _is_ahead(scene: StreetScene, user: DetectedObstacle) -> bool:
    """Return whether a road user drives on the way of the car already."""
    line = scene.road.route.line
    place = line.project(user.x_m, user.y_m, scene.s_m, 0.0, scene.soon_m)
    turned_rad = math.remainder(user.yaw_rad - place.heading_rad, 2.0 * math.pi)
    beside_m = abs(place.cross_track_m - scene.way.offset_at(place.s_m))
    is_along = beside_m < scene.inside_m and abs(turned_rad) < ALONG_RAD
    return is_along and place.s_m > scene.s_m


def _claims(
    scene: StreetScene, crossing: Crossing, number: int, user: DetectedObstacle, place: LanePlace
) -> Iterator[Claim]:
    for conflict in crossing.conflicts:
        away_m = conflict.away_m(scene.network, place)
        if away_m is None:
            continue
        room_m = away_m - 0.5 * user.length_m
        # A road user that stands elsewhere than at its line is in a queue, or was let in.
        if user.speed_mps < AT_REST_MPS and not 0.0 <= room_m < scene.settings.proposals.wait_m:
            continue
        # A road user that would have to brake hard does not give way.
        braking_mps2 = scene.settings.prediction.yields_mps2
        stops_m = user.speed_mps**2 / (2.0 * braking_mps2)
        runs = user.speed_mps > AT_REST_MPS and room_m < stops_m
        yields = not (conflict.is_first or runs)
        yield Claim(number, crossing, conflict, away_m, room_m, yields)


def passes_s(s_m: np.ndarray, place_m: float) -> np.ndarray:
    """Return (P,) times at which the car passes a place, inf: it does not [s].

    Args:
        s_m: (T, P) arc lengths of the car's centre [m]
        place_m: the place [m]
    """
    after = s_m >= place_m
    first, columns = after.argmax(axis=0), np.arange(s_m.shape[1])
    before = np.maximum(first - 1, 0)
    step_m = s_m[first, columns] - s_m[before, columns]
    share = (place_m - s_m[before, columns]) / np.where(step_m > 0.0, step_m, math.inf)
    times_s = STEP_S * np.where(first > 0, before + share, 0.0)
    return np.where(after.any(axis=0), times_s, math.inf)


def taken_s(scene: StreetScene, s_m: np.ndarray, claim: Claim) -> np.ndarray:
    """Return (P,) for how long the car takes the right of way of a road user [s].

    It is the mean of all that the road user may do: for how long both are in the space of the
    junction that both need, or within `clear_s` of it; or, where the road user arrives at the
    junction soon after the car enters it, how much too soon.

    Args:
        scene: the scene
        s_m: (T, P) arc lengths of the car's centre on the proposals [m]
        claim: the road user
    """
    margins, front_m = scene.settings.streets, scene.settings.front_m
    user, conflict = scene.obstacles[claim.number], claim.conflict
    line_m = claim.crossing.line_m - front_m
    enters_s = passes_s(s_m, conflict.own_m[0] - BESIDE_M - front_m)
    leaves_s = np.minimum(passes_s(s_m, conflict.own_m[1] + front_m), TIMES_S[-1])
    if conflict.merges:  # behind the car, it follows
        leaves_s = np.minimum(leaves_s, enters_s + margins.clear_s)
    begins_s = passes_s(s_m, line_m)
    outside = line_m + OVER_M > scene.s_m
    total_s, half_m = np.zeros_like(enters_s), 0.5 * user.length_m
    space_m = claim.room_m + conflict.its_m[0], claim.away_m + conflict.its_m[1] + half_m
    places_m = claim.room_m, *space_m
    for weight, (arrives_s, in_s, out_s) in reaches_s(scene, user, places_m):
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
