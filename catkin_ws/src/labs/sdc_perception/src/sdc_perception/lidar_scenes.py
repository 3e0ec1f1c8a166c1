"""Scans of the roof's lidar in random places, and how well a function finds what is there.

python3 -m sdc_perception.lidar_scenes [SEED ...] prints it for your find_clusters.
"""

from __future__ import annotations

import math
import sys
from types import SimpleNamespace
from typing import Any, Callable, NamedTuple

import numpy as np

from sdc_perception.lidar_clusters import CAR, OTHER, PEDESTRIAN, find_clusters
from sdc_perception.study.scenes import NO_SCENERY, place
from sdc_sim.physics.obstacles import ObstaclePlan, ObstacleState, SimulatedObstacle
from sdc_sim.road.random_routes import random_route
from sdc_sim.road.road import Road
from sdc_sim.road.scenery import Scenery
from sdc_sim.sensors.lidar import RoofLidar
from sdc_sim.sensors.model import Moment, SensorContext, sensor_settings

# A body counts as visible with so many points.
_VISIBLE = 8
# A cluster is that of a body when its centre is in the body's outline, or so far from it.
_NEAR_M = 0.5
# A wrong cluster that is farther away does not count: it may be a body with few points.
_FAR_M = 19.0


class Scan(NamedTuple):
    """A scan and the truth."""

    points_m: np.ndarray  # (N, 3) in the frame of the lidar
    bodies: list  # ObstacleState of each car and pedestrian near the lidar, in its frame


def scans(seed: int, count: int = 8) -> list[Scan]:
    """Return random scans on a random road between trees and houses, of a car that pitches."""
    random = np.random.default_rng(seed)
    road = Road(random_route(seed % 1000)[0])
    lidar = _lidar(road.scenery())
    return [_random_scan(road, lidar, random, tick) for tick in range(count)]


def empty_road(*bodies: tuple, pitch_rad: float = 0.0, rain: int = 0) -> np.ndarray:
    """Return a scan (N, 3) of bodies, (kind, x, y, yaw) each, on a road without scenery."""
    table = [_body(*body) for body in bodies]
    points = _points(_lidar(NO_SCENERY), (0.0, 0.0, 0.0), table, 1)
    return _weathered(points, pitch_rad, rain, np.random.default_rng(1))


def _lidar(scenery: Scenery) -> Any:
    settings = sensor_settings("lidar", {"period_s": 0.1, "range_m": 60.0, "noise_m": 0.02})
    parameters: Any = None
    return RoofLidar(settings, SensorContext(1, 3, 0.1, parameters, None, lambda: scenery))


def _body(kind: str, x_m: float, y_m: float, yaw_rad: float) -> ObstacleState:
    return SimulatedObstacle(1, ObstaclePlan.stationary(kind, x_m, y_m, yaw_rad)).body


def _points(lidar: Any, pose: tuple, bodies: list, tick: int) -> np.ndarray:
    state: Any = SimpleNamespace(**dict(zip(("x_m", "y_m", "yaw_rad"), pose)))
    return lidar.read(Moment(0.0, state, bodies), tick)[:, :3].astype(float)


def _weathered(
    points_m: np.ndarray, pitch_rad: float, rain: int, random: np.random.Generator
) -> np.ndarray:
    """Return a scan with drops of rain, of a car that pitches."""
    drops = random.uniform((-20.0, -20.0, -1.5), (20.0, 20.0, 1.0), (rain, 3))
    c, s = math.cos(pitch_rad), math.sin(pitch_rad)
    turn = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    return np.vstack([points_m, drops]) @ turn


def _random_scan(road: Road, lidar: Any, random: np.random.Generator, tick: int) -> Scan:
    s_m = random.uniform(5.0, road.length_m - 30.0)
    pose = place(road, s_m, 0.0)
    bodies: list[ObstacleState] = []
    for kind in (CAR, CAR, CAR, PEDESTRIAN, PEDESTRIAN, PEDESTRIAN):
        left = random.choice((0.0, 3.5)) if kind == CAR else random.uniform(-3.0, 6.5)
        x, y, yaw = place(road, s_m + random.uniform(6.0, 20.0), left + random.normal(0.0, 0.2))
        apart = (math.dist((x, y), (body.x_m, body.y_m)) for body in bodies)
        if min(apart, default=9.0) > (5.5 if kind == CAR else 3.8):
            bodies.append(_body(kind, x, y, yaw + random.normal(0.0, 0.15)))
    points = _points(lidar, pose, bodies, tick)
    seen = [_in_frame(body, *pose) for body in bodies]
    visible = [body for body in seen if np.sum(_inside(body, points, 0.1)) >= _VISIBLE]
    pitch_rad = math.radians(random.uniform(-2.0, 2.0))
    return Scan(_weathered(points, pitch_rad, 15, random), visible)


def _in_frame(body: ObstacleState, x: float, y: float, yaw: float) -> ObstacleState:
    c, s = math.cos(yaw), math.sin(yaw)
    dx, dy = body.x_m - x, body.y_m - y
    return body._replace(x_m=c * dx + s * dy, y_m=c * dy - s * dx, yaw_rad=body.yaw_rad - yaw)


def _inside(body: ObstacleState, points_m: np.ndarray, more_m: float) -> np.ndarray:
    """Return which points (N,) are in the outline of a body and above the ground."""
    c, s = math.cos(body.yaw_rad), math.sin(body.yaw_rad)
    dx, dy = points_m[:, 0] - body.x_m, points_m[:, 1] - body.y_m
    ahead, left = np.abs(c * dx + s * dy), np.abs(c * dy - s * dx)
    return (
        (ahead < 0.5 * body.length_m + more_m)
        & (left < 0.5 * body.width_m + more_m)
        & (points_m[:, 2] > -2.2)
    )


class Score(NamedTuple):
    """How well cars and pedestrians were found in some scans."""

    recall: float  # share of the visible bodies that were found
    precision: float  # share of right ones among the clusters that are right, or near


def score(find: Callable[[np.ndarray], list], examples: list[Scan]) -> Score:
    """Return how well a function finds the bodies of some scans."""
    total = np.zeros(4, int)
    for points, bodies in examples:
        clusters = [cluster for cluster in find(points.copy()) if cluster.label != OTHER]
        places = np.array([[cluster.x_m, cluster.y_m, 0.0] for cluster in clusters]).reshape(-1, 3)
        labels = np.array([cluster.label for cluster in clusters], str)
        hits = [_inside(body, places, _NEAR_M) & (labels == body.kind) for body in bodies]
        right = np.any(hits, axis=0) if hits else np.zeros(len(places), bool)
        near = np.hypot(places[:, 0], places[:, 1]) < _FAR_M
        found = sum(bool(hit.any()) for hit in hits)
        total += (found, len(bodies), int(np.sum(right | near)), int(right.sum()))
    return Score(total[0] / max(total[1], 1), total[3] / max(total[2], 1))


def main() -> None:
    """Print a line for each seed."""
    for seed in map(int, sys.argv[1:] or ("1", "2", "3")):
        recall, precision = score(find_clusters, scans(seed))
        print(f"road {seed}: recall {recall:.2f}, precision {precision:.2f}")


if __name__ == "__main__":
    main()
