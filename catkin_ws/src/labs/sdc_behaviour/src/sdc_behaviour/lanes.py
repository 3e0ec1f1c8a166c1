"""Where a road user will be: it follows its lane, and drives straight on at junctions."""

from __future__ import annotations

import math

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_map.network import Network

# A road user on no lane, or one that crosses its lane, is predicted straight ahead.
_LANE_M = 2.5  # a road user within this distance of the middle of a lane is on it
_ACROSS_RAD = 1.0  # a road user with a greater angle to its lane crosses it


def place_ahead(network: Network, lane_id: str, s_m: float, distance_m: float) -> tuple[str, float]:
    """Return the lane, and the distance from its start, that is so far ahead along the lanes.

    Args:
        network: the lanes
        lane_id: the lane at the beginning
        s_m: distance from the start of this lane [m]
        distance_m: way along the lanes, not negative [m]

    Returns:
        id of the lane, and distance from its start [m]; where no lane follows, the end of the last
    """
    lane = network.lanes[lane_id]
    s_m = s_m + distance_m
    # TODO 1: go on to network.straight_on(lane), which is None at a dead end
    while s_m > lane.length_m:
        following = network.straight_on(lane)
        if following is None:
            return lane.id, lane.length_m
        s_m, lane = s_m - lane.length_m, following
    # ----------------------------------------------------------------------------
    return lane.id, s_m


def predicted(network: Network, user: DetectedObstacle, times_s: np.ndarray) -> np.ndarray:
    """Return the places (T, 2) of a road user at some times from now, with its speed of now [m]."""
    way_m = user.speed_mps * times_s
    place = network.nearest(user.x_m, user.y_m, user.yaw_rad, _LANE_M)
    if place is None or abs(place.heading_error_rad) > _ACROSS_RAD:
        ahead = np.array([np.cos(user.yaw_rad), np.sin(user.yaw_rad)])
        return np.array([user.x_m, user.y_m]) + way_m[:, None] * ahead
    points = np.empty((len(times_s), 2))
    for row, distance_m in enumerate(way_m.tolist()):
        lane_id, s_m = place_ahead(network, place.lane, place.s_m, distance_m)
        line = network.lanes[lane_id].line
        (x, y), heading = line.point_at(s_m), line.direction_at(s_m)
        # It keeps its distance from the middle of the lane.
        aside_m = place.cross_track_m
        points[row] = x - aside_m * math.sin(heading), y + aside_m * math.cos(heading)
    return points
