"""The map view of the manual control: road, path, obstacles and car from above, heading up."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

from sdc_common.validation import check_positive
from sdc_sim.camera.painting import FIXED_POINT_BITS, footprint
from sdc_sim.camera.rasterizer import fill
from sdc_sim.road.network_markings import world_markings
from sdc_sim.road.road_markings import RoadMarkings, speed_colours

# Blue, green, red.
_GRASS = (70, 105, 80)
_ASPHALT = (78, 76, 74)
_LINE = (225, 225, 225)
_CAR = (200, 60, 30)
_GLASS = (60, 40, 30)
_OBSTACLE = (30, 130, 240)

_CAR_SIZE_M, _WINDSCREEN_SIZE_M, _WINDSCREEN_AHEAD_M = (4.7, 2.0), (0.6, 1.5), 0.7


class MapView:
    """Draws a map around the car.

    Args:
        m_per_pixel: scale [m]
        full_speed_mps: target speed that is drawn green [m/s]
        size: width and height of the picture [pixels]

    Raises:
        ValueError: the scale or the speed is not positive.
    """

    def __init__(self, m_per_pixel: float, full_speed_mps: float, size: tuple = (640, 480)):
        check_positive(m_per_pixel=m_per_pixel, full_speed_mps=full_speed_mps)
        self._m_per_pixel, self._full_speed_mps, self._size = m_per_pixel, full_speed_mps, size
        self._reach_m = m_per_pixel * math.hypot(*size) + 10.0
        self._markings: RoadMarkings | None = None

    def set_route(self, route_m: np.ndarray, map_path: str = "") -> None:
        """Build the road along an (N, 2) route [m], or the streets of a map.

        Raises:
            ValueError: the route is not valid; the previous road stays.
        """
        self._markings = world_markings(route_m, map_path)

    def to_pixels(self, points_m: np.ndarray, pose: Sequence[float]) -> np.ndarray:
        """Return the pixels (..., 2), right and down, of points in a picture around a pose."""
        c, s = math.cos(pose[2]), math.sin(pose[2])
        offset = (np.asarray(points_m, dtype=float) - pose[:2]) / self._m_per_pixel
        width, height = self._size
        return (0.5 * width, 0.7 * height) - offset @ [[-s, c], [c, s]]

    def picture(
        self, pose: Sequence[float], path: Sequence = (), obstacles: Sequence = ()
    ) -> np.ndarray:
        """Return the picture around the car as (H, W, 3) BGR uint8.

        Args:
            pose: x [m], y [m] and heading [rad] of the car in the map
            path: rows of x, y [m], target speed [m/s]
            obstacles: rows of x, y [m], yaw [rad], length, width [m]
        """
        canvas = np.full((self._size[1], self._size[0], 3), _GRASS, np.uint8)

        def fixed_point(points_m: np.ndarray) -> np.ndarray:
            pixels = np.clip(self.to_pixels(points_m, pose), -1e4, 1e4)
            return np.round(pixels * 2**FIXED_POINT_BITS).astype(np.int32)

        def near(shapes_m: np.ndarray) -> np.ndarray:
            return shapes_m[np.abs(shapes_m[:, 0] - pose[:2]).max(axis=1) < self._reach_m]

        def draw_lines(lines: list, colour: Sequence[float], thickness: int = 1) -> None:
            cv2.polylines(canvas, lines, False, colour, thickness, cv2.LINE_AA, FIXED_POINT_BITS)

        if self._markings is not None:
            for surface in fixed_point(near(self._markings.surface)):
                cv2.fillConvexPoly(canvas, surface, _ASPHALT, cv2.LINE_8, FIXED_POINT_BITS)
            for segments in (self._markings.edges, self._markings.dashes):
                draw_lines(list(fixed_point(near(segments))), _LINE)
        rows = _finite_rows(path, 3)
        segments = fixed_point(np.stack([rows[:-1, :2], rows[1:, :2]], axis=1))
        colours = 255.0 * speed_colours(rows[:-1, 2], self._full_speed_mps)[:, ::-1]
        for segment, colour in zip(segments, colours.tolist()):
            draw_lines([segment], colour, 3)
        bodies = [(*row, _OBSTACLE) for row in _finite_rows(obstacles, 5).tolist()]
        x, y, yaw = pose
        c, s = _WINDSCREEN_AHEAD_M * math.cos(yaw), _WINDSCREEN_AHEAD_M * math.sin(yaw)
        bodies.append((*pose, *_CAR_SIZE_M, _CAR))
        bodies.append((x + c, y + s, yaw, *_WINDSCREEN_SIZE_M, _GLASS))
        for x, y, yaw, length, width, colour in bodies:
            fill(canvas, fixed_point(footprint((x, y), yaw, (length, width))), colour)
        return canvas


def _finite_rows(rows: Sequence, columns: int) -> np.ndarray:
    array = np.asarray(rows, dtype=float).reshape(-1, columns)
    return array[np.isfinite(array).all(axis=1)]
