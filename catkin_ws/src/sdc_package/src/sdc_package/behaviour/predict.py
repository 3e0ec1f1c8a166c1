"""The predictor: where each road user will be, along its lane, in the coordinates of the route."""

from __future__ import annotations

import math
from functools import lru_cache, partial
from typing import Any, Iterator, NamedTuple

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_map.network import LanePlace, Network
from sdc_package.behaviour.road import ALONG_RAD, VEHICLE_M, onward, places_on
from sdc_package.behaviour.scene import AT_REST_MPS, StreetScene
from sdc_package.obstacle_prediction import Obstacles

# Steps of time in which proposals are simulated among the others [s].
STEP_S = 0.4
STEPS = 26
TIMES_S = STEP_S * np.arange(STEPS)
# What a road user does, and what one may do that should give way to the car.
GOES_ON = "goes_on"
UNSEEN = "unseen"
# Lanes of road users are looked up so near to them [m].
_LANE_M = 2.5


class Predicted(NamedTuple):
    """Predictions of road users; a row for each thing that each may do, arrays (T, R)."""

    user: np.ndarray  # (R,) index of the road user in the observation
    weight: np.ndarray  # (R,) how likely it does that
    goes_on: np.ndarray  # (R,) whether it just goes on
    s_m: np.ndarray  # arc length along the route, see RoadAlong [m]
    y_m: np.ndarray  # place across the road [m]
    along_mps: np.ndarray  # speed along the route [m/s]
    left_mps: np.ndarray  # (R,) speed across it at first [m/s]
    half_length_m: np.ndarray  # half of the size along the route, and the front of the car [m]
    half_width_m: np.ndarray  # half of the sizes of both across it [m]

    @property
    def aligned(self) -> np.ndarray:
        """(R,) whether each drives in the direction of the car at first."""
        return self.along_mps[0] > np.abs(self.left_mps)


class Predictor:
    """Predicts road users on a network of streets, so far along their lanes [m]."""

    def __init__(self, network: Network, ahead_m: float):
        self.network = network
        self._onward = lru_cache(None)(partial(onward, network, ahead_m=ahead_m))
        self._places: dict[DetectedObstacle, LanePlace | None] = {}
        self._last: dict[int, LanePlace | None] = {}  # by the id of the road user

    def place_of(self, user: DetectedObstacle) -> LanePlace | None:
        """Return the place of a vehicle that drives along its lane, else None."""
        if user.length_m < VEHICLE_M:
            return None
        if user not in self._places:
            pose = user.x_m, user.y_m, user.yaw_rad
            place = self._further(user) or self.network.nearest(*pose, _LANE_M, user.z_m)
            is_along = place is not None and abs(place.heading_error_rad) < ALONG_RAD
            self._places[user] = place if is_along else None
        return self._places[user]

    def _further(self, user: DetectedObstacle) -> LanePlace | None:
        """Return a place farther on the last lane, None if the road user has left it."""
        last = self._last.get(user.id)
        if last is None:
            return None
        lane = self.network.lanes[last.lane]
        at = lane.line.project(user.x_m, user.y_m, last.s_m, 0.0, user.length_m)
        error_rad = math.remainder(user.yaw_rad - at.heading_rad, 2.0 * math.pi)
        is_inside = last.s_m <= at.s_m < lane.length_m and at.distance_m < 0.5 * user.width_m
        if not is_inside or abs(error_rad) > ALONG_RAD:
            return None
        return LanePlace(last.lane, at.s_m, at.cross_track_m, error_rad)

    def predict(self, scene: StreetScene, stops_m: dict[int, float]) -> Predicted:
        """Return what the road users near the car may do.

        Those that give way to the car, by their indices, stop so far from where they are [m].
        """
        seen = scene.settings.prediction
        goes = [number for number, _ in reaching(scene, scene.s_m)]
        users = goes + [number for number in goes if number in stops_m]
        goes_on = np.arange(len(users)) < len(goes)
        weights = np.where(goes_on, seen.weights[GOES_ON], seen.weights[UNSEEN])
        to_m = np.where(goes_on, [stops_m.get(number, math.inf) for number in users], math.inf)
        seen_users = [scene.obstacles[number] for number in users]
        motions = self._motions(scene, seen_users, to_m[:, None])
        self._last = {user.id: place for user, place in self._places.items() if user.id}
        self._places = {}
        along = scene.road.along(scene.s_m, scene.sight_m, motions, seen_users)
        left_mps = (along.y_m[1] - along.y_m[0]) / STEP_S
        keep = (np.abs(along.beside_m) < seen.beside_m + along.half_width_m).any(axis=0)
        found = np.array(users, int), weights, goes_on, along.s_m, along.y_m, along.along_mps
        half_length_m = along.half_length_m + scene.settings.front_m
        sizes = left_mps, half_length_m, along.half_width_m + 0.5 * scene.settings.width_m
        return Predicted(*(part[..., keep] for part in (*found, *sizes)))

    def _motions(self, scene: StreetScene, users: Obstacles, to_m: np.ndarray) -> np.ndarray:
        """Return (5, T, R) x, y, headings, speeds and heights of R that go on so far (R, 1) [m]."""
        known, lines = [], []
        for user in users:
            place = self.place_of(user) if user.speed_mps >= AT_REST_MPS else None
            c, s = math.cos(user.yaw_rad), math.sin(user.yaw_rad)
            straight = 0.0, user.x_m, user.y_m, user.yaw_rad, user.z_m, c, s, 0.0, 0.0
            lines.append(self._onward(place.lane) if place else np.array([straight]))
            track, at = scene.tracker.of(user), place[1:] if place else (0.0, 0.0, 0.0)
            size = user.yaw_rad, user.speed_mps, 0.5 * user.length_m
            known.append((*at, *size, track.acceleration_mps2))
        rows = np.array(known).reshape(-1, 7).T[..., None]
        s_m, beside_m, error_rad, yaw_rad, speed_mps, half_m, mps2 = rows
        travel_m, mps = travels(scene, speed_mps, mps2)
        mps, travel_m = np.where(travel_m < to_m, mps, 0.0), np.minimum(travel_m, to_m)
        # In a bend, a long body has the heading of the lane at some place along it.
        at_m = np.maximum(np.hstack([s_m + travel_m, s_m - half_m, s_m + half_m]), 0.0)
        poses = np.array([*map(places_on, lines, at_m)]).reshape(*at_m.shape, 4)
        ends_rad, (x, y, heading, z) = poses[:, STEPS:, 2], np.moveaxis(poses[:, :STEPS], -1, 0)
        error_rad = error_rad + heading[:, :1]
        error_rad -= np.clip(error_rad, *np.sort(ends_rad).T[..., None])
        # Who moves across its lane goes on with it for a short time, or to the middle of the lane.
        across_s = np.minimum(TIMES_S, scene.settings.prediction.across_s)
        left_m = beside_m + across_s * speed_mps * np.sin(error_rad)
        left_m[left_m * beside_m < 0.0] = 0.0
        x, y = x - left_m * np.sin(heading), y + left_m * np.cos(heading)
        heading[:, :1] = yaw_rad
        return np.array([x, y, heading, mps, z]).transpose(0, 2, 1)


def reaching(scene: StreetScene, s_m: float) -> Iterator[tuple[int, DetectedObstacle]]:
    """Yield the road users, with their indices, that may come to a place of the route in time."""
    place = scene.road.route.line.point_at(s_m)
    for number, user in enumerate(scene.obstacles):
        reach_m = scene.soon_m + TIMES_S[-1] * user.speed_mps
        if math.dist((user.x_m, user.y_m), place) <= reach_m:
            yield number, user


def travels(scene: StreetScene, speed_mps: Any, mps2: np.ndarray) -> np.ndarray:
    """Return ways [m] and speeds [m/s] (R, T) of R (R, 1) that accelerate for a time [m/s^2]."""
    mps2 = np.minimum(mps2, scene.settings.streets.hardest_mps2)  # it seems more if its speed jumps
    stops_s = np.divide(-speed_mps, mps2, np.full_like(mps2, math.inf), where=mps2 < 0.0)
    for_s = np.minimum(TIMES_S, np.minimum(scene.settings.prediction.accelerates_s, stops_s))
    mps = speed_mps + for_s * mps2
    return np.array([TIMES_S * mps - 0.5 * mps2 * for_s**2, mps])


def may_travel(scene: StreetScene, user: DetectedObstacle) -> tuple[list[float], np.ndarray]:
    """Return how likely each thing is that a road user may do, and its ways (K, T) then [m]."""
    seen, own_mps2 = scene.settings.prediction, scene.tracker.of(user).acceleration_mps2
    mps2 = own_mps2, max(own_mps2, seen.starts_mps2), min(own_mps2, -seen.brakes_mps2)
    ways_m, _ = travels(scene, user.speed_mps, np.array(mps2)[:, None])
    return [seen.weights[name] for name in (GOES_ON, "changes_speed", "changes_speed")], ways_m


def times_at(places_m: Any, way_m: np.ndarray) -> np.ndarray:
    """Return when a way (T,) reaches places; inf for those that it does not reach [s]."""
    return np.interp(places_m, way_m, TIMES_S, right=math.inf)
