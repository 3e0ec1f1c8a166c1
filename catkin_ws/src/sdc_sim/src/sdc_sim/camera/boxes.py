"""Cars, pedestrians, obstacles and traffic lights of the camera picture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from sdc_sim.camera.meshes import table_mesh, traffic_light_mesh
from sdc_sim.camera.painting import FIXED_POINT_BITS, SUN, footprint, shadow_hull
from sdc_sim.camera.rasterizer import PolygonRasterizer, Solid, fill
from sdc_sim.physics.obstacles import FIRST_TRAFFIC_ID, KINDS, ObstacleState
from sdc_sim.physics.traffic_lights import GREEN, HEIGHT_M, OFF, RED, YELLOW, TrafficLightState
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.simulation.weather import SHADE

_LIGHT_SIZE_M = 0.4
_EGO_SIZE_M = (4.7, 2.0, 1.5)
_EGO_BGR = (120, 60, 25)
# Red, green, blue of the cars of the traffic.
_CAR_COLOURS = (
    *((0.75, 0.76, 0.78), (0.12, 0.12, 0.13), (0.63, 0.16, 0.16), (0.15, 0.25, 0.5)),
    *((0.9, 0.9, 0.88), (0.4, 0.42, 0.44), (0.2, 0.38, 0.25)),
)
# Blue, green, red of the lamp that is lit; of a light that is off, the glass of the red lamp.
_LIT_BGR = {RED: (40, 40, 255), YELLOW: (40, 200, 255), GREEN: (90, 255, 60), OFF: (20, 20, 62)}


@dataclass(frozen=True)
class Box:
    """A body on the ground."""

    x_m: float  # centre in the map [m]
    y_m: float  # centre in the map [m]
    yaw_rad: float  # heading in the map [rad]; the lamps of a traffic light face along it
    length_m: float = 4.7
    width_m: float = 2.0
    height_m: float = 1.45  # the picture of a traffic light has a fixed one
    # Blue, green, red, 0..255; of a traffic light that of the lamp that is lit.
    colour_bgr: tuple[int, ...] = (40, 40, 160)
    kind: str = "car"  # 'car', 'pedestrian', 'obstacle' (a plain box) or 'light' (a traffic light)


def ego_box(state: VehicleState) -> Box:
    """Return the own car as the cameras outside it draw it."""
    return Box(state.x_m, state.y_m, state.yaw_rad, *_EGO_SIZE_M, _EGO_BGR, "car")


def obstacle_box(obstacle: ObstacleState) -> Box:
    """Return an obstacle as the camera draws it."""
    colour = KINDS[obstacle.kind].colour
    if obstacle.kind == "car" and obstacle.id >= FIRST_TRAFFIC_ID:
        colour = _CAR_COLOURS[obstacle.id % len(_CAR_COLOURS)]
    bgr = tuple(round(255 * share) for share in reversed(colour))
    return Box(*obstacle[2:8], bgr, obstacle.kind)


def traffic_light_box(light: TrafficLightState) -> Box:
    """Return a traffic light as the camera draws it: it faces the cars that it applies to."""
    size = _LIGHT_SIZE_M, _LIGHT_SIZE_M, HEIGHT_M
    yaw_rad = light.heading_rad + math.pi
    return Box(light.x_m, light.y_m, yaw_rad, *size, _LIT_BGR[light.state], "light")


def box_solid(box: Box, eye: np.ndarray) -> Solid:
    """Return the faces of a box as an eye at x, y, z [m] sees them."""
    light = box.kind == "light"
    mesh = traffic_light_mesh(tuple(box.colour_bgr)) if light else table_mesh(box.kind)
    c, s = np.cos(box.yaw_rad), np.sin(box.yaw_rad)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    # The mesh of a traffic light is in metres already.
    size = np.array((1.0,) * 3 if light else (box.length_m, box.width_m, box.height_m))
    polygons = (mesh.corners * size) @ turn + (box.x_m, box.y_m, 0.0)
    normals = (mesh.normals / size) @ turn
    normals /= np.sqrt((normals * normals).sum(axis=1))[:, None]
    shade = np.maximum(0.62 + 0.42 * np.maximum(normals @ SUN, 0.0), mesh.glow)
    colours = np.where(mesh.tinted[:, None], np.array(box.colour_bgr, float), mesh.colours)
    bgr = np.minimum(colours * shade[:, None], 255.0)
    solid = Solid(polygons, normals, bgr, np.zeros(len(bgr), bool))
    if box.kind in ("pedestrian", "bicycle", "lorry"):  # some faces hide others
        far = ((polygons - eye).mean(axis=1) ** 2).sum(axis=1)
        solid = Solid(*(column[np.argsort(-far, kind="stable")] for column in solid))
    return solid


def draw_box_shadow(picture: np.ndarray, rasterizer: PolygonRasterizer, box: Box) -> None:
    """Darken the ground in the shadow of a box."""
    thin = box.kind == "light"
    size = (0.15, 0.15) if thin else (0.96 * box.length_m, 0.96 * box.width_m)
    base = footprint((box.x_m, box.y_m), box.yaw_rad, size)
    hull = shadow_hull(base, 0.85 * box.height_m)
    outline = rasterizer.outline(np.column_stack([hull, np.zeros(len(hull))]))
    if outline is None:
        return
    low = np.maximum(outline.min(axis=0) >> FIXED_POINT_BITS, 0)
    high = np.minimum(
        (outline.max(axis=0) >> FIXED_POINT_BITS) + 2, [picture.shape[1], picture.shape[0]]
    )
    if np.any(high <= low):
        return
    factor = np.full((high[1] - low[1], high[0] - low[0], 4), 255, np.uint8)
    dark = int(255 * SHADE)
    fill(factor, outline - (low << FIXED_POINT_BITS), (dark, dark, dark, 255))
    part = picture[low[1] : high[1], low[0] : high[0]]
    cv2.multiply(part, factor, dst=part, scale=1.0 / 255.0)
