"""The solid bodies of the world for the lidars: the shapes that the camera draws.

Each kind of body computes where the beams of a lidar enter and leave its bodies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple, Sequence, Union

import numpy as np

from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import TrafficLightState
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
    chosen,
)
from sdc_sim.yaml_document import packaged_config

FAR_M = 1e9


class Rays(NamedTuple):
    """The beams that may hit bodies."""

    owner: np.ndarray  # number of the body of each beam (B,)
    dx: np.ndarray  # from the lidar to the origins of the bodies (N,) [m]
    dy: np.ndarray  # from the lidar to the origins of the bodies (N,) [m]
    east: np.ndarray  # direction of each beam (B,)
    north: np.ndarray  # direction of each beam (B,)
    slopes: np.ndarray  # slope of each ring (R, 1)
    height_m: float  # height of the lidar


@dataclass(frozen=True, eq=False)
class Frusta:
    """Bodies with four sides, a horizontal top and a horizontal bottom, one row each."""

    position_m: np.ndarray  # origin in the map (N, 2)
    yaw_rad: np.ndarray  # direction of the body's x axis in the map (N,)
    # Distances from the origin to the front, rear, left and right side at the bottom (N, 4).
    reach_m: np.ndarray
    lean: np.ndarray  # by how much these distances grow for each metre upwards (N, 4)
    bottom_m: np.ndarray  # height of the bottom (N,)
    top_m: np.ndarray  # height of the top (N,)

    @cached_property
    def _axis(self) -> tuple[np.ndarray, np.ndarray]:
        return np.cos(self.yaw_rad), np.sin(self.yaw_rad)

    @cached_property
    def radius_m(self) -> np.ndarray:
        """Distance (N,) from the origin within which the body is."""
        widest = np.maximum(
            self.reach_m, self.reach_m + self.lean * (self.top_m - self.bottom_m)[:, None]
        )
        return np.hypot(widest[:, :2].max(axis=1), widest[:, 2:].max(axis=1))

    def _offset(self, dx: np.ndarray, dy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the origins along and across their own axes, from the lidar."""
        c, s = self._axis
        return c * dx + s * dy, c * dy - s * dx

    def inside(self, rays: Rays) -> tuple[np.ndarray, np.ndarray]:
        """Return the distances on the ground at which beams enter and leave their bodies.

        Returns:
            arrays (B,) or (R, B) that do not consider bottom and top
        """
        owner = rays.owner
        c, s = (one[owner] for one in self._axis)
        ahead, aside = c * rays.east + s * rays.north, c * rays.north - s * rays.east
        along, across = self._offset(rays.dx, rays.dy)
        front, rear, left, right = self.reach_m.T
        if not self.lean.any():
            # A beam moves by (ahead, aside) for each metre, from (-along, -across).
            low, high = ((along - rear)[owner] / ahead, (along + front)[owner] / ahead)
            near, far = ((across - right)[owner] / aside, (across + left)[owner] / aside)
            enter = np.maximum(np.minimum(low, high), np.minimum(near, far))
            return enter, np.minimum(np.maximum(low, high), np.maximum(near, far))
        above_m = rays.height_m - self.bottom_m
        enter, leave = np.full(1, -FAR_M), np.full(1, FAR_M)
        for reach, lean, origin, speed in zip(
            (front, rear, left, right),
            self.lean.T,
            (along, -along, across, -across),
            (ahead, -ahead, aside, -aside),
        ):
            gap = (reach + origin + lean * above_m)[owner]
            speed = speed - lean[owner] * rays.slopes
            side = gap / speed
            enter = np.maximum(enter, np.where(speed < 0.0, side, -FAR_M))
            leave = np.minimum(leave, np.where(speed > 0.0, side, FAR_M))
            leave = np.where((speed == 0.0) & (gap < 0.0), -1.0, leave)
        return enter, leave


@dataclass(frozen=True, eq=False)
class Cylinders:
    """Upright cylinders: position_m (N, 2), radius_m (N,), bottom_m (N,), top_m (N,)."""

    position_m: np.ndarray
    radius_m: np.ndarray
    bottom_m: np.ndarray
    top_m: np.ndarray

    def inside(self, rays: Rays) -> tuple[np.ndarray, np.ndarray]:
        """Return where beams enter and leave; see Frusta.inside."""
        owner, dx, dy = rays.owner, rays.dx, rays.dy
        along = dx[owner] * rays.east + dy[owner] * rays.north
        half = np.sqrt(along * along + (self.radius_m**2 - dx * dx - dy * dy)[owner])
        return along - half, along + half


@dataclass(frozen=True, eq=False)
class Balls:
    """Balls: position_m (N, 2) and height_m (N,) of the centre, radius_m (N,)."""

    position_m: np.ndarray
    height_m: np.ndarray
    radius_m: np.ndarray

    bottom_m = top_m = None

    def inside(self, rays: Rays) -> tuple[np.ndarray, np.ndarray]:
        """Return where beams enter and leave; see Frusta.inside."""
        owner, dx, dy = rays.owner, rays.dx, rays.dy
        dz = self.height_m - rays.height_m
        along = dx[owner] * rays.east + dy[owner] * rays.north + rays.slopes * dz[owner]
        square = (dx * dx + dy * dy + dz * dz - self.radius_m**2)[owner]
        steep = 1.0 + rays.slopes * rays.slopes
        half = np.sqrt(along * along - steep * square)
        return (along - half) / steep, (along + half) / steep


Bodies = Union[Frusta, Cylinders, Balls]


def angles(bodies: Bodies, dx: np.ndarray, dy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the directions in the map between which each body is, seen from a lidar (N,) [rad].

    Args:
        bodies: the bodies
        dx: from the lidar to their origins (N,) [m]
        dy: from the lidar to their origins (N,) [m]
    """
    share = bodies.radius_m / np.sqrt(dx * dx + dy * dy)
    half = np.arcsin(np.minimum(share, 1.0))
    half[share >= 1.0] = np.pi
    middle = np.arctan2(dy, dx)
    return middle - half, middle + half


def scenery_bodies(scenery: Scenery) -> list[Bodies]:
    """Return walls, roofs, trunks and crowns; a roof is one body that ends at the gables."""
    length, width, height = scenery.size_m.T
    tree, house = scenery.kind == TREE, scenery.kind == HOUSE
    half = 0.5 * np.stack([length, length, width, width], axis=1)
    zero = np.zeros(len(scenery))
    place_m, yaw_rad = scenery.position_m, scenery.yaw_rad
    walls_top_m = np.where(house, EAVES_SHARE, 1.0) * height
    roof_m = half + (0.0, 0.0, ROOF_BEYOND_EAVES_M, ROOF_BEYOND_EAVES_M)
    bottom_m = EAVES_SHARE * height - ROOF_BELOW_EAVES_M
    lean = np.zeros_like(half)
    lean[:, 2:] = -roof_m[:, 2:] / (height - bottom_m)[:, None]
    centre_m = CROWN_CENTRE_SHARE * height
    return [
        chosen(Frusta(place_m, yaw_rad, half, np.zeros_like(half), zero, walls_top_m), ~tree),
        chosen(Frusta(place_m, yaw_rad, roof_m, lean, bottom_m, height), house),
        chosen(Cylinders(place_m, TRUNK_RADIUS_SHARE * height, zero, centre_m), tree),
        chosen(Balls(place_m, centre_m, CROWN_RADIUS_SHARE * height), tree),
    ]


@lru_cache(maxsize=None)
def _prisms(kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the solid parts of a mesh.

    Returns:
        distances of front, rear, left and right side at the bottom and at the top (2, P, 4), and
        heights of bottom and top (2, P), as config/meshes.yaml has them
    """
    rows = [row for row in packaged_config("meshes")[kind] if "prism" in row]
    rectangles = np.array([[row["prism"], row["top"]] for row in rows], float)
    # From x0, x1, y0, y1 to the distances.
    sides = rectangles[..., [1, 0, 3, 2]] * (1.0, -1.0, 1.0, -1.0)
    return sides.swapaxes(0, 1), np.array([row["z"] for row in rows], float).T


def moving_bodies(
    obstacles: Sequence[ObstacleState], lights: Sequence[TrafficLightState]
) -> list[Frusta]:
    """Return the solid parts of obstacles and traffic lights."""
    places = [(one.kind, *one.rectangle, one.height_m) for one in obstacles]
    # The lamps face the cars, against the heading of the lane.
    places += [
        ("light", one.x_m, one.y_m, one.heading_rad + math.pi, 1.0, 1.0, 1.0) for one in lights
    ]
    parts = []
    for kind, x_m, y_m, yaw_rad, length_m, width_m, height_m in places:
        sides, heights = _prisms(kind)
        (reach, at_top), count = sides * (length_m, length_m, width_m, width_m), sides.shape[1]
        bottom_m, top_m = heights * height_m
        lean = (at_top - reach) / (top_m - bottom_m)[:, None]
        position_m = np.tile([x_m, y_m], (count, 1))
        parts.append((position_m, np.full(count, yaw_rad), reach, lean, bottom_m, top_m))
    frusta = Frusta(*map(np.concatenate, zip(*parts)))
    upright = ~frusta.lean.any(axis=1)
    return [chosen(frusta, rows) for rows in (upright, ~upright)]


def near(bodies: Bodies, x_m: float, y_m: float, reach_m: float) -> Bodies:
    """Return the bodies whose origins are nearer than this to a place in the map [m]."""
    offset = bodies.position_m - (x_m, y_m)
    return chosen(bodies, (offset * offset).sum(axis=1) < reach_m**2)
