"""Street planners on small roads and in the town, and a point that drives as they plan."""

import math
from dataclasses import replace

import numpy as np
from planned_roads import street_parameters

from sdc_common.driving import DetectedObstacle, Observation
from sdc_common.geometry.road_line import road_route
from sdc_map.network import BROKEN, Network, RoadLane
from sdc_package.behaviour.street_planner import StreetPlanner
from sdc_package.local_path import ReferencePath
from sdc_package.street_settings import StreetSettings
from sdc_package.traffic_lights import TrafficLightMonitor

# Width of a lane [m].
WIDTH_M = 3.5
# Length of the roads [m].
LENGTH_M = 700.0
# Planned speed on them [m/s].
MOST_MPS = 12.0
# Time between two observations.
TICK_S = 0.05
TICK_NS = 50_000_000
SETTINGS = StreetSettings.read(street_parameters().__getitem__)


def new_planner(network, points_m, limits_mps=None, lines=(), score_function="", **options):
    """Return a planner that follows a mission."""
    lights = TrafficLightMonitor(SETTINGS.planner.traffic_lights)
    lights.lines = dict(lines)
    settings = replace(SETTINGS, score_function=score_function)
    planner = StreetPlanner(network, settings, lights, **options)
    limits_mps = np.full(len(points_m), MOST_MPS) if limits_mps is None else limits_mps
    planner.follow(np.asarray(points_m, float), limits_mps, MOST_MPS)
    return planner


def lane(name, y_m, back=False, **changes):
    points = np.array([[-100.0, y_m], [LENGTH_M, y_m]])
    return RoadLane(name, points[::-1] if back else points, WIDTH_M, 14.0, **changes)


def two_way(marking=BROKEN):
    """Return a street with a lane in each direction."""
    own = lane("e_0", 0.0, left_marking=marking)
    return Network("street", [own, lane("w_0", WIDTH_M, back=True, left_marking=marking)])


def two_lanes():
    """Return a road with two lanes of one direction."""
    right = lane("e_0", 0.0, left="e_1", left_marking=BROKEN)
    return Network("road", [right, lane("e_1", WIDTH_M, right="e_0", right_marking=BROKEN)])


def straight(length_m=LENGTH_M):
    return np.column_stack([np.arange(length_m), np.zeros(int(length_m))])


def changing(at_m):
    """Return points of a route that changes from the right lane to the left one."""
    t = np.clip((np.arange(LENGTH_M) - at_m) / 40.0, 0.0, 1.0)
    return np.column_stack([np.arange(LENGTH_M), WIDTH_M * t**3 * (10.0 - 15.0 * t + 6.0 * t * t)])


class Other:
    """One that keeps its speed and its way, from a place at time 0."""

    def __init__(self, x_m, y_m=0.0, speed_mps=0.0, number=7, kind="car", size=(4.7, 1.9)):
        self.x_m, self.y_m, self.speed_mps, self.number = x_m, y_m, speed_mps, number
        self.kind, self.size = kind, size

    def at(self, time_s):
        yaw = 0.0 if self.speed_mps >= 0.0 else math.pi
        place = self.x_m + time_s * self.speed_mps, self.y_m, yaw, *self.size
        return DetectedObstacle(*place, abs(self.speed_mps), self.number, self.kind)


def seen_at(x_m, y_m, speed_mps, others=(), tick=1, yaw_rad=0.0):
    return Observation(tick * TICK_NS, x_m, y_m, yaw_rad, speed_mps, list(others))


def drive(network, others, duration_s, points_m=None, start=(0.0, 0.0, 8.0)):
    """Let a point drive as the planner demands and the controller reads it.

    Returns rows of time, x, y and speed.

    It meets none of the others.
    """
    points_m = straight() if points_m is None else points_m
    planner, route = new_planner(network, points_m), road_route(points_m)
    reference = ReferencePath()
    s, y, v = start
    rows = []
    for tick in range(round(duration_s / TICK_S)):
        seen = [other.at(tick * TICK_S) for other in others]
        place = s, y + float(np.interp(s, *points_m.T))
        reference.update(planner.plan(seen_at(*place, v, seen, tick)).points)
        wanted = reference.nearest(*place).speed_mps
        v = max(v + min(max(wanted - v, -6.0 * TICK_S), 1.8 * TICK_S), 0.0)
        s, y = s + v * TICK_S, planner.way.offset_at(s) if tick else y
        rows.append((tick * TICK_S, s, float(np.interp(s, *points_m.T)) + y, v))
        for user in seen:
            is_beside = abs(user.y_m - rows[-1][2]) > 0.5 * (user.width_m + SETTINGS.width_m)
            away_m = abs(user.x_m - s) - 0.5 * user.length_m - SETTINGS.front_m
            assert is_beside or away_m > 0.0, f"meets {user} at {rows[-1]}"
    assert route.length_m > s
    return np.array(rows)


def y_at(rows, x_m):
    """Return the place across the road where a drive passes an x [m]."""
    return float(np.interp(x_m, rows[:, 1], rows[:, 2]))
