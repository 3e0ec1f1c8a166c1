"""The map view of the manual control: road, path, obstacles and car from above, heading up."""

from __future__ import annotations

import math
from typing import Sequence

import cv2
import numpy as np

from sdc_sim.camera.painting import footprint
from sdc_sim.road.road import Road
from sdc_sim.road.road_markings import RoadMarkings, road_markings, speed_colours

# Blue, green, red.
_GRASS = (70, 105, 80)
_ASPHALT = (78, 76, 74)
_LINE = (225, 225, 225)
_CAR = (200, 60, 30)
_GLASS = (60, 40, 30)
_OUTLINE = (255, 255, 255)
_OBSTACLE = (30, 130, 240)

_CAR_LENGTH_M, _CAR_WIDTH_M = 4.7, 2.0
_CAR_OUTLINE_M = np.array(
    [
        (0.5, 0.35),
        (0.42, 0.5),
        (-0.46, 0.5),
        (-0.5, 0.4),
        (-0.5, -0.4),
        (-0.46, -0.5),
        (0.42, -0.5),
        (0.5, -0.35),
    ]
) * (_CAR_LENGTH_M, _CAR_WIDTH_M)
_WINDSCREEN_M = np.array([(0.21, 0.38), (0.08, 0.32), (0.08, -0.32), (0.21, -0.38)]) * (
    _CAR_LENGTH_M,
    _CAR_WIDTH_M,
)
_SHIFT = 4  # fractional bits of the pixels that are drawn


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
        if not m_per_pixel > 0.0:
            raise ValueError(f"the scale of the map must be positive, got {m_per_pixel}")
        speed_colours([], full_speed_mps)
        self._m_per_pixel = m_per_pixel
        self._full_speed_mps = full_speed_mps
        self._size = size
        self._reach_m = m_per_pixel * math.hypot(*size) + 10.0
        self._markings: RoadMarkings | None = None

    def set_route(self, route_m: np.ndarray) -> None:
        """Build the road along an (N, 2) route [m].

        Raises:
            ValueError: the route is not valid; the previous road stays.
        """
        self._markings = road_markings(Road(route_m))

    def to_pixels(self, points_m: np.ndarray, x_m: float, y_m: float, yaw_rad: float) -> np.ndarray:
        """Return the pixels of points in the map frame, in a picture around the car.

        Args:
            points_m: points, shape (..., 2) [m]
            x_m: position of the car [m]
            y_m: position of the car [m]
            yaw_rad: heading of the car [rad]

        Returns:
            pixels to the right and down, shape (..., 2)
        """
        offset = np.asarray(points_m, dtype=float) - (x_m, y_m)
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        return self._pixels(offset @ (c, s), offset @ (-s, c))

    def _pixels(self, forward_m: np.ndarray, left_m: np.ndarray) -> np.ndarray:
        width, height = self._size
        return np.stack(
            [
                0.5 * width - left_m / self._m_per_pixel,
                0.7 * height - forward_m / self._m_per_pixel,
            ],
            axis=-1,
        )

    def picture(
        self,
        x_m: float,
        y_m: float,
        yaw_rad: float,
        path: Sequence | None = None,
        obstacles: Sequence | None = None,
    ) -> np.ndarray:
        """Return the picture around the car as (H, W, 3) BGR uint8.

        Args:
            x_m: position of the car [m]
            y_m: position of the car [m]
            yaw_rad: heading of the car [rad]
            path: rows of x, y [m], target speed [m/s]
            obstacles: rows of x, y [m], yaw [rad], length, width [m]
        """
        pose = (x_m, y_m, yaw_rad)
        canvas = np.full((self._size[1], self._size[0], 3), _GRASS, np.uint8)
        if self._markings is not None:
            self._draw_road(canvas, self._markings, pose)
        rows = _finite_rows(path, 3)
        if len(rows) > 1:
            self._draw_path(canvas, rows, pose)
        for x, y, yaw, length, width in _finite_rows(obstacles, 5).tolist():
            corners = self.to_pixels(footprint((x, y), yaw, (length, width)), *pose)
            _fill(canvas, _fixed_point(corners), _OBSTACLE)
        outline = _fixed_point(self._pixels(*_CAR_OUTLINE_M.T))
        _fill(canvas, outline, _CAR)
        _fill(canvas, _fixed_point(self._pixels(*_WINDSCREEN_M.T)), _GLASS)
        _draw_lines(canvas, [outline], _OUTLINE, closed=True)
        return canvas

    def _draw_road(self, canvas: np.ndarray, markings: RoadMarkings, pose: tuple) -> None:
        for quadrilateral in self._pixels_near(markings.surface, pose):
            _fill(canvas, quadrilateral, _ASPHALT, cv2.LINE_8)
        for segments in (markings.edges, markings.dashes):
            _draw_lines(canvas, list(self._pixels_near(segments, pose)), _LINE)

    def _draw_path(self, canvas: np.ndarray, path: np.ndarray, pose: tuple) -> None:
        segments = np.stack([path[:-1, :2], path[1:, :2]], axis=1)
        pixels = _fixed_point(self.to_pixels(segments, *pose))
        colours = 255.0 * speed_colours(path[:-1, 2], self._full_speed_mps)[:, ::-1]
        for segment, colour in zip(pixels, colours.tolist()):
            _draw_lines(canvas, [segment], colour, thickness=3)

    def _pixels_near(self, shapes_m: np.ndarray, pose: tuple) -> np.ndarray:
        """Return the fixed-point pixels of the shapes (N, corners, 2) near the car."""
        near = np.abs(shapes_m[:, 0] - pose[:2]).max(axis=1) < self._reach_m
        return _fixed_point(self.to_pixels(shapes_m[near], *pose))


def _fill(canvas: np.ndarray, corners: np.ndarray, colour: tuple, line: int = cv2.LINE_AA) -> None:
    cv2.fillConvexPoly(canvas, corners, colour, line, _SHIFT)


def _draw_lines(
    canvas: np.ndarray, lines: list, colour: tuple, thickness: int = 1, closed: bool = False
) -> None:
    cv2.polylines(canvas, lines, closed, colour, thickness, cv2.LINE_AA, _SHIFT)


def _finite_rows(rows: Sequence | None, columns: int) -> np.ndarray:
    array = np.asarray(() if rows is None else rows, dtype=float).reshape(-1, columns)
    return array[np.isfinite(array).all(axis=1)]


def _fixed_point(pixels: np.ndarray) -> np.ndarray:
    return np.round(np.clip(pixels, -1e4, 1e4) * 2**_SHIFT).astype(np.int32)
