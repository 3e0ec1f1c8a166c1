"""The predictor: where each road user will be, along its lane, in the coordinates of the route."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Callable, Iterator, NamedTuple, Sequence

import numpy as np

from sdc_common.driving import DetectedObstacle, other_level
from sdc_map.network import LanePlace, Network
from sdc_package.behaviour.road import ALONG_RAD, VEHICLE_M
from sdc_package.behaviour.scene import AT_REST_MPS, StreetScene

# Steps of time in which proposals are simulated among the others [s].
STEP_S = 0.4
STEPS = 26
TIMES_S = STEP_S * np.arange(STEPS)
# What a road user may do; the last one is for those that should give way to the car.
GOES_ON = "goes_on"
ACCELERATES = "accelerates"
BRAKES = "brakes"
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
    half_length_m: np.ndarray  # half of the size along the route [m]
    half_width_m: np.ndarray  # half of the size across it [m]


class Onward(NamedTuple):
    """The way straight on from the begin of a lane."""

    s_m: np.ndarray
    points_m: np.ndarray  # (N, 2)
    heading_rad: np.ndarray  # (N,), continuous
    z_m: np.ndarray  # (N,) height


class Predictor:
    """Predicts road users on a network of streets.

    Args:
        network: the lanes
        ahead_m: so far the lanes are followed [m]
    """

    def __init__(self, network: Network, ahead_m: float):
        self._network, self._ahead_m = network, ahead_m
        self._onward: Callable[[str], Onward] = lru_cache(None)(self._straight_on)
        self._places: dict[DetectedObstacle, LanePlace | None] = {}
        self._last: dict[int, LanePlace | None] = {}  # by the id of the road user

    def update(self) -> None:
        """Forget the places; call it before each decision."""
        self._last = {user.id: place for user, place in self._places.items() if user.id}
        self._places = {}

    def place_of(self, user: DetectedObstacle) -> LanePlace | None:
        """Return the place of a vehicle that drives along its lane, else None."""
        if user.length_m < VEHICLE_M:
            return None
        if user not in self._places:
            self._places[user] = self._further(user) or self._network.nearest(
                user.x_m, user.y_m, user.yaw_rad, _LANE_M, user.z_m
            )
        place = self._places[user]
        return place if place and abs(place.heading_error_rad) < ALONG_RAD else None

    def _further(self, user: DetectedObstacle) -> LanePlace | None:
        """Return a place farther on the last lane, None if the road user has left it."""
        last = self._last.get(user.id)
        if last is None:
            return None
        lane = self._network.lanes[last.lane]
        at = lane.line.project(user.x_m, user.y_m, last.s_m, 0.0, user.length_m)
        error_rad = math.remainder(user.yaw_rad - at.heading_rad, 2.0 * math.pi)
        is_inside = last.s_m <= at.s_m < lane.length_m and at.distance_m < 0.5 * user.width_m
        if not is_inside or abs(error_rad) > ALONG_RAD:
            return None
        return LanePlace(last.lane, at.s_m, at.cross_track_m, error_rad)

    def predict(self, scene: StreetScene, stops_m: dict[int, float]) -> Predicted:
        """Return what the road users near the car may do.

        Args:
            scene: the scene
            stops_m: how far from each that gives way to the car, by its index, it stops [m]
        """
        seen = scene.settings.prediction
        users, names, poses = [], [], []
        for number, user in reaching(scene, scene.s_m):
            stop_m = stops_m.get(number, math.inf)
            for name in (GOES_ON, UNSEEN) if number in stops_m else (GOES_ON,):
                users.append(number)
                names.append(name)
                poses.append(self._poses(scene, user, stop_m if name == GOES_ON else math.inf))
        x_m, y_m, yaw_rad, mps, z_m = np.array(poses).reshape(-1, 5, STEPS).transpose(1, 2, 0)
        seen_users = [scene.obstacles[number] for number in users]
        along = scene.road.along(scene.sight_m, x_m, y_m, yaw_rad, seen_users)
        left_mps = (along.y_m[1] - along.y_m[0]) / STEP_S
        near = np.abs(along.beside_m) < seen.beside_m + along.half_width_m
        near &= (along.s_m > scene.sight_m[0]) & (along.s_m < scene.sight_m[1])
        half_width_m = along.half_width_m
        if not self._network.is_flat:  # what is on another level has no place on the road
            over = other_level(z_m, np.interp(along.s_m, scene.road.route.s, scene.road.z_m))
            near, half_width_m = near & ~over, np.where(over, -math.inf, half_width_m)
        keep = near.any(axis=0)
        weights = np.array([seen.weights[name] for name in names])
        goes_on = np.array([name == GOES_ON for name in names], bool)
        found = np.array(users, int), weights, goes_on, along.s_m, along.y_m, mps * along.cos
        sizes = left_mps, along.half_length_m, half_width_m
        return Predicted(*(part[..., keep] for part in (*found, *sizes)))

    def _poses(self, scene: StreetScene, user: DetectedObstacle, stop_m: float) -> np.ndarray:
        """Return (5, T) x, y, heading, speed and height while it goes on to a place."""
        travel_m, mps = travels(scene, user, acceleration_mps2(scene, user))
        mps, travel_m = np.where(travel_m < stop_m, mps, 0.0), np.minimum(travel_m, stop_m)
        place = self.place_of(user) if user.speed_mps >= AT_REST_MPS else None
        if place is None:
            c, s = math.cos(user.yaw_rad), math.sin(user.yaw_rad)
            x, y = user.x_m + c * travel_m, user.y_m + s * travel_m
            return np.array([x, y, np.full(STEPS, user.yaw_rad), mps, np.full(STEPS, user.z_m)])
        onward = self._onward(place.lane)
        at = place.s_m + travel_m
        heading = np.interp(at, onward.s_m, onward.heading_rad)
        # Who moves across its lane goes on with it for a short time. In a bend, a long body has the
        # heading of the lane at some place along it.
        half_m, yaw_rad = 0.5 * user.length_m, place.heading_error_rad + heading[0]
        ends_m = place.s_m - half_m, place.s_m + half_m
        along_rad = np.interp(ends_m, onward.s_m, onward.heading_rad)
        error_rad = yaw_rad - min(max(yaw_rad, along_rad.min()), along_rad.max())
        across_s = np.minimum(TIMES_S, scene.settings.prediction.across_s)
        left_m = place.cross_track_m + across_s * user.speed_mps * math.sin(error_rad)
        x = np.interp(at, onward.s_m, onward.points_m[:, 0]) - left_m * np.sin(heading)
        y = np.interp(at, onward.s_m, onward.points_m[:, 1]) + left_m * np.cos(heading)
        beyond_m = np.maximum(at - onward.s_m[-1], 0.0)
        x, y = x + beyond_m * np.cos(heading), y + beyond_m * np.sin(heading)
        heading[0] = user.yaw_rad
        return np.array([x, y, heading, mps, np.interp(at, onward.s_m, onward.z_m)])

    def _straight_on(self, name: str) -> Onward:
        lane = self._network.lanes[name]
        points, length_m = [np.column_stack([lane.points_m, lane.z_m])], lane.length_m
        while length_m < self._ahead_m:
            following = self._network.straight_on(lane)
            if following is None:
                break
            lane = following
            points.append(np.column_stack([lane.points_m, lane.z_m]))
            length_m += lane.length_m
        line = np.vstack(points)
        line = line[np.append(True, np.hypot(*np.diff(line[:, :2], axis=0).T) > 0.0)]
        steps = np.diff(line[:, :2], axis=0)
        s_m = np.append(0.0, np.cumsum(np.hypot(*steps.T)))
        heading = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
        middle = 0.5 * (s_m[1:] + s_m[:-1])
        return Onward(s_m, line[:, :2], np.interp(s_m, middle, heading), line[:, 2])


def reaching(scene: StreetScene, s_m: float) -> Iterator[tuple[int, DetectedObstacle]]:
    """Yield the road users, with their indices, that may come to a place of the route in time."""
    place = scene.road.route.line.point_at(s_m)
    for number, user in enumerate(scene.obstacles):
        reach_m = scene.soon_m + TIMES_S[-1] * user.speed_mps
        if math.dist((user.x_m, user.y_m), place) <= reach_m:
            yield number, user


def acceleration_mps2(scene: StreetScene, user: DetectedObstacle) -> float:
    """Return the acceleration with which a road user goes on [m/s^2]."""
    seen = scene.settings.prediction
    mps2 = scene.tracker.of(user).acceleration_mps2
    return mps2 if abs(mps2) > seen.steady_mps2 else 0.0


def travels(
    scene: StreetScene, user: DetectedObstacle, mps2: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far a road user drives (T,) [m], and its speed (T,) [m/s].

    Args:
        scene: the scene
        user: the road user
        mps2: its acceleration, for some time [m/s^2]
    """
    for_s = np.minimum(TIMES_S, scene.settings.prediction.accelerates_s)
    if mps2 < 0.0:
        for_s = np.minimum(for_s, -user.speed_mps / mps2)
    mps = user.speed_mps + for_s * mps2
    return TIMES_S * mps - 0.5 * mps2 * for_s**2, mps


def reaches_s(
    scene: StreetScene, user: DetectedObstacle, places_m: Sequence[float]
) -> Iterator[tuple[float, list[float]]]:
    """Yield how likely each thing is that a road user may do, and when it reaches places then [s].

    Args:
        scene: the scene
        user: the road user
        places_m: distances along its way; inf is yielded for those that it does not reach [m]
    """
    seen, own_mps2 = scene.settings.prediction, acceleration_mps2(scene, user)
    for name, mps2 in (
        (GOES_ON, own_mps2),
        (ACCELERATES, max(own_mps2, seen.starts_mps2)),
        (BRAKES, min(own_mps2, -seen.brakes_mps2)),
    ):
        travel_m = travels(scene, user, mps2)[0]
        times_s = [np.interp(at, travel_m, TIMES_S, right=math.inf) for at in places_m]
        yield seen.weights[name], times_s
