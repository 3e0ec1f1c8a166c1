"""The predictor: where each road user will be, along its lane, in the coordinates of the route."""

from __future__ import annotations

import math
from functools import lru_cache, partial
from typing import Any, Iterator, NamedTuple

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_common.geometry.route import interpolate
from sdc_map.network import LanePlace, Network
from sdc_package.behaviour.road import ALONG_RAD, VEHICLE_M, onward
from sdc_package.behaviour.scene import AT_REST_MPS, StreetScene

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
        users, names, poses = [], [], []
        for number, user in reaching(scene, scene.s_m):
            stops_at_m = {GOES_ON: stops_m.get(number, math.inf)}
            if number in stops_m:
                stops_at_m[UNSEEN] = math.inf
            for name, stop_m in stops_at_m.items():
                users.append(number)
                names.append(name)
                poses.append(self._poses(scene, user, stop_m))
        self._last = {user.id: place for user, place in self._places.items() if user.id}
        self._places = {}
        motions = np.array(poses).reshape(-1, 5, STEPS).transpose(1, 2, 0)
        seen_users = [scene.obstacles[number] for number in users]
        along = scene.road.along(scene.s_m, scene.sight_m, motions, seen_users)
        left_mps = (along.y_m[1] - along.y_m[0]) / STEP_S
        near = np.abs(along.beside_m) < seen.beside_m + along.half_width_m
        keep = near.any(axis=0)
        weights = np.array([seen.weights[name] for name in names])
        goes_on = np.array([name == GOES_ON for name in names], bool)
        found = np.array(users, int), weights, goes_on, along.s_m, along.y_m, along.along_mps
        half_length_m = along.half_length_m + scene.settings.front_m
        sizes = left_mps, half_length_m, along.half_width_m + 0.5 * scene.settings.width_m
        return Predicted(*(part[..., keep] for part in (*found, *sizes)))

    def _poses(self, scene: StreetScene, user: DetectedObstacle, stop_m: float) -> np.ndarray:
        """Return (5, T) x, y, heading, speed and height while it goes on to a place."""
        travel_m, mps = travels(scene, user, scene.tracker.of(user).acceleration_mps2)
        mps, travel_m = np.where(travel_m < stop_m, mps, 0.0), np.minimum(travel_m, stop_m)
        place = self.place_of(user) if user.speed_mps >= AT_REST_MPS else None
        if place is None:
            c, s = math.cos(user.yaw_rad), math.sin(user.yaw_rad)
            x, y = user.x_m + c * travel_m, user.y_m + s * travel_m
            return np.array([x, y, np.full(STEPS, user.yaw_rad), mps, np.full(STEPS, user.z_m)])
        ahead = self._onward(place.lane)
        x, y, heading, z = interpolate(place.s_m + travel_m, ahead[:, 0], ahead[:, 1:]).T
        # Who moves across its lane goes on with it for a short time, or to the middle of the lane.
        # In a bend, a long body has the heading of the lane at some place along it.
        half_m, yaw_rad = 0.5 * user.length_m, place.heading_error_rad + heading[0]
        ends_m = place.s_m - half_m, place.s_m + half_m
        along_rad = np.interp(ends_m, ahead[:, 0], ahead[:, 3])
        error_rad = yaw_rad - min(max(yaw_rad, along_rad.min()), along_rad.max())
        across_s = np.minimum(TIMES_S, scene.settings.prediction.across_s)
        left_m = place.cross_track_m + across_s * user.speed_mps * math.sin(error_rad)
        left_m[left_m * place.cross_track_m < 0.0] = 0.0
        x, y = x - left_m * np.sin(heading), y + left_m * np.cos(heading)
        heading[0] = user.yaw_rad
        return np.array([x, y, heading, mps, z])


def reaching(scene: StreetScene, s_m: float) -> Iterator[tuple[int, DetectedObstacle]]:
    """Yield the road users, with their indices, that may come to a place of the route in time."""
    place = scene.road.route.line.point_at(s_m)
    for number, user in enumerate(scene.obstacles):
        reach_m = scene.soon_m + TIMES_S[-1] * user.speed_mps
        if math.dist((user.x_m, user.y_m), place) <= reach_m:
            yield number, user


def travels(scene: StreetScene, user: DetectedObstacle, mps2: float) -> np.ndarray:
    """Return the way (T,) [m] and speeds (T,) [m/s] of one that accelerates for a time [m/s^2]."""
    mps2 = min(mps2, scene.settings.streets.hardest_mps2)  # it seems more if its speed jumps
    stops_s = -user.speed_mps / mps2 if mps2 < 0.0 else math.inf
    for_s = np.minimum(TIMES_S, min(scene.settings.prediction.accelerates_s, stops_s))
    mps = user.speed_mps + for_s * mps2
    return np.array([TIMES_S * mps - 0.5 * mps2 * for_s**2, mps])


def may_travel(scene: StreetScene, user: DetectedObstacle) -> Iterator[tuple[float, np.ndarray]]:
    """Yield how likely each thing is that a road user may do, and its way (T,) then [m]."""
    seen, own_mps2 = scene.settings.prediction, scene.tracker.of(user).acceleration_mps2
    for name, mps2 in (
        (GOES_ON, own_mps2),
        ("changes_speed", max(own_mps2, seen.starts_mps2)),
        ("changes_speed", min(own_mps2, -seen.brakes_mps2)),
    ):
        yield seen.weights[name], travels(scene, user, mps2)[0]


def times_at(places_m: Any, way_m: np.ndarray) -> np.ndarray:
    """Return when a way (T,) reaches places; inf for those that it does not reach [s]."""
    return np.interp(places_m, way_m, TIMES_S, right=math.inf)
