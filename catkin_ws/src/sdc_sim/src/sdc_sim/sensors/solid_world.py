"""The solid bodies of the world for the lidars: the shapes that the camera draws."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple, Sequence

import numpy as np

from sdc_sim.physics.meshes import (
    Mesh,
    car_mesh,
    obstacle_mesh,
    pedestrian_mesh,
    traffic_light_mesh,
)
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import HEIGHT_M, TrafficLightState
from sdc_sim.road.scenery import (
    CROWN_CENTRE_SHARE,
    CROWN_RADIUS_SHARE,
    EAVES_SHARE,
    HOUSE,
    ROOF_BELOW_EAVES_M,
    ROOF_BEYOND_EAVES_M,
    TREE,
    TRUNK_RADIUS_SHARE,
    Scenery,
)
from sdc_sim.sensors.solid_bodies import (
    Balls,
    Cylinders,
    Frusta,
    PlacedBalls,
    PlacedBodies,
    PlacedCylinders,
    PlacedFrusta,
    chosen,
    joined,
)

# The near bodies are chosen again after the vehicle has moved so far.
_STRIDE_M = 10.0
_OFF_BGR = (20.0, 20.0, 62.0)
_MESHES = {
    "car": car_mesh,
    "pedestrian": pedestrian_mesh,
    "obstacle": obstacle_mesh,
    "light": lambda: traffic_light_mesh(HEIGHT_M, _OFF_BGR),
}


class Bodies(NamedTuple):
    """Bodies of all kinds."""

    frusta: Frusta
    cylinders: Cylinders
    balls: Balls


def scenery_bodies(scenery: Scenery) -> Bodies:
    """Return trees, houses and blocks of flats.

    A tree is a trunk and a ball; the roof of a house is one body that ends at the gables.
    """
    length, width, height = scenery.size_m.T
    tree, house = scenery.kind == TREE, scenery.kind == HOUSE
    half = 0.5 * np.stack([length, length, width, width], axis=1)
    zero = np.zeros(len(scenery))
    walls = Frusta(
        scenery.position_m,
        scenery.yaw_rad,
        half,
        np.zeros_like(half),
        zero,
        np.where(house, EAVES_SHARE, 1.0) * height,
    )
    roof_m = half + (0.0, 0.0, ROOF_BEYOND_EAVES_M, ROOF_BEYOND_EAVES_M)
    bottom = EAVES_SHARE * height - ROOF_BELOW_EAVES_M
    lean = np.zeros_like(half)
    lean[:, 2:] = -roof_m[:, 2:] / (height - bottom)[:, None]
    roofs = walls._replace(reach_m=roof_m, lean=lean, bottom_m=bottom, top_m=height)
    return Bodies(
        joined([chosen(walls, ~tree), chosen(roofs, house)]),
        chosen(
            Cylinders(
                scenery.position_m, TRUNK_RADIUS_SHARE * height, zero, CROWN_CENTRE_SHARE * height
            ),
            tree,
        ),
        chosen(
            Balls(scenery.position_m, CROWN_CENTRE_SHARE * height, CROWN_RADIUS_SHARE * height),
            tree,
        ),
    )


@lru_cache(maxsize=None)
def _mesh(kind: str) -> Mesh:
    return _MESHES[kind]()


def mesh_frusta(
    mesh: Mesh, x_m: float, y_m: float, yaw_rad: float, size_m: Sequence[float]
) -> Frusta:
    """Return the solid parts of a mesh at a place in the map.

    Args:
        mesh: the mesh
        x_m: its origin
        y_m: its origin
        yaw_rad: direction of its x axis
        size_m: length, width and height of a mesh in the unit cube
    """
    length, width, high = size_m
    scale = np.array([length, length, width, width])
    low, top = mesh.prisms[:, :4] * scale, mesh.prisms[:, 4:8] * scale
    bottom_m, top_m = mesh.prisms[:, 8] * high, mesh.prisms[:, 9] * high
    # From x0, x1, y0, y1 to the distances of front, rear, left and right side.
    sides, signs = [1, 0, 3, 2], [1.0, -1.0, 1.0, -1.0]
    reach, reach_at_top = low[:, sides] * signs, top[:, sides] * signs
    count = len(mesh.prisms)
    return Frusta(
        np.tile([x_m, y_m], (count, 1)),
        np.full(count, yaw_rad),
        reach,
        (reach_at_top - reach) / (top_m - bottom_m)[:, None],
        bottom_m,
        top_m,
    )


def moving_bodies(
    obstacles: Sequence[ObstacleState], lights: Sequence[TrafficLightState]
) -> list[PlacedBodies]:
    """Return the solid parts of obstacles and traffic lights."""
    parts = [
        mesh_frusta(
            _mesh(one.kind),
            one.x_m,
            one.y_m,
            one.yaw_rad,
            (one.length_m, one.width_m, one.height_m),
        )
        for one in obstacles
    ]
    for light in lights:
        # The lamps face the cars, against the heading of the lane.
        yaw_rad = light.heading_rad + math.pi
        parts.append(mesh_frusta(_mesh("light"), light.x_m, light.y_m, yaw_rad, (1.0, 1.0, 1.0)))
    if not parts:
        return []
    frusta = joined(parts)
    upright = ~frusta.lean.any(axis=1)
    return [PlacedFrusta(chosen(frusta, rows)) for rows in (upright, ~upright)]


class NearBodies:
    """Finds the bodies of the scenery that are in range.

    Args:
        scenery: trees and buildings
        range_m: range of the lidar
        height_m: height of the lidar if all its beams are level, None otherwise
    """

    def __init__(self, scenery: Scenery, range_m: float, height_m: float | None = None):
        frusta, cylinders, balls = scenery_bodies(scenery)
        if height_m is not None:
            cut = (frusta.bottom_m <= height_m) & (height_m <= frusta.top_m)
            frusta = chosen(frusta, cut)
            cylinders = chosen(cylinders, height_m <= cylinders.top_m)
            balls = chosen(balls, abs(balls.height_m - height_m) < balls.radius_m)
        upright = ~frusta.lean.any(axis=1)
        self._frusta = chosen(frusta, upright), chosen(frusta, ~upright)
        self._cylinders, self._balls = cylinders, balls
        # No body of the scenery reaches farther from its centre.
        largest_m = float(np.hypot(*scenery.size_m[:, :2].T).max(initial=0.0))
        self._limit_m = range_m + _STRIDE_M + 0.5 * largest_m + ROOF_BEYOND_EAVES_M
        self._place_m: tuple[float, float] | None = None
        self._near: list[PlacedBodies] = []

    def around(self, x_m: float, y_m: float) -> list[PlacedBodies]:
        """Return at least the bodies in range of a place in the map."""
        if self._place_m is None or math.dist(self._place_m, (x_m, y_m)) > _STRIDE_M:
            self._place_m = x_m, y_m
            cylinders, balls = self._cylinders, self._balls
            self._near = [
                *(PlacedFrusta(chosen(one, self._is_near(one.position_m))) for one in self._frusta),
                PlacedCylinders(chosen(cylinders, self._is_near(cylinders.position_m))),
                PlacedBalls(chosen(balls, self._is_near(balls.position_m))),
            ]
        return self._near

    def _is_near(self, position_m: np.ndarray) -> np.ndarray:
        offset = position_m - self._place_m
        return np.flatnonzero((offset * offset).sum(axis=1) < self._limit_m**2)
