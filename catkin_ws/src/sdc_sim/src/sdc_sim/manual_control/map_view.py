"""The map view of the hand control: the road, the planned path and the car from above, with the car's nose up."""

from __future__ import annotations

import math

import cv2
import numpy as np

from sdc_sim.road.road import Road
from sdc_sim.road.road_markings import road_markings, speed_colours

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
_BOX = np.array([(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)])
_SHIFT = 4  # fractional bits of the pixels that are drawn


class MapView:
    """Draws the surroundings of a car as pictures of `size` (width, height) pixels.

    m_per_pixel: scale. full_speed_mps: target speed that is drawn green. Raises ValueError where one of them is not positive.
    """

    def __init__(self, m_per_pixel: float, full_speed_mps: float, size=(640, 480)):
        if not m_per_pixel > 0.0:
            raise ValueError(f"the scale of the map must be positive, got {m_per_pixel}")
        speed_colours([], full_speed_mps)
        self._m_per_pixel = m_per_pixel
        self._full_speed_mps = full_speed_mps
        self._size = size
        self._reach_m = m_per_pixel * math.hypot(*size) + 10.0
        self._paint = None

    def set_route(self, route_m) -> None:
        """Lay the road along an (N, 2) route. Raises ValueError for a route that is none; the last road stays then."""
        self._paint = road_markings(Road(route_m))

    def to_pixels(self, points_m, x_m: float, y_m: float, yaw_rad: float) -> np.ndarray:
        """Pixels (..., 2), right and down, of points (..., 2) in the map frame, around a car with this pose."""
        forward, left = _in_car_frame(np.asarray(points_m, dtype=float), x_m, y_m, yaw_rad)
        return self._place(forward, left)

    def _place(self, forward_m: np.ndarray, left_m: np.ndarray) -> np.ndarray:
        width, height = self._size
        return np.stack(
            [
                0.5 * width - left_m / self._m_per_pixel,
                0.7 * height - forward_m / self._m_per_pixel,
            ],
            axis=-1,
        )

    def picture(
        self, x_m: float, y_m: float, yaw_rad: float, path=None, obstacles=None
    ) -> np.ndarray:
        """The (H, W, 3) BGR uint8 picture around a car with this pose. path: (N, 3) x, y, target speed; obstacles: (N, 5) x, y,
        yaw, length, width; or None."""
        canvas = np.full((self._size[1], self._size[0], 3), _GRASS, np.uint8)
        if self._paint is not None:
            pixels = self._pixels_near(self._paint.surface, x_m, y_m, yaw_rad)
            for quadrilateral in pixels:
                cv2.fillConvexPoly(canvas, quadrilateral, _ASPHALT, cv2.LINE_8, _SHIFT)
            for segments in (self._paint.edges, self._paint.dashes):
                cv2.polylines(
                    canvas,
                    list(self._pixels_near(segments, x_m, y_m, yaw_rad)),
                    False,
                    _LINE,
                    1,
                    cv2.LINE_AA,
                    _SHIFT,
                )
        path = _finite_rows(path, 3)
        if len(path) > 1:
            self._draw_path(canvas, path, x_m, y_m, yaw_rad)
        for x, y, yaw, length, width in _finite_rows(obstacles, 5).tolist():
            corners = _in_map(_BOX * (length, width), x, y, yaw)
            cv2.fillConvexPoly(
                canvas,
                _fixed_point(self.to_pixels(corners, x_m, y_m, yaw_rad)),
                _OBSTACLE,
                cv2.LINE_AA,
                _SHIFT,
            )
        for outline, colour in ((_CAR_OUTLINE_M, _CAR), (_WINDSCREEN_M, _GLASS)):
            cv2.fillConvexPoly(
                canvas, _fixed_point(self._place(*outline.T)), colour, cv2.LINE_AA, _SHIFT
            )
        cv2.polylines(
            canvas,
            [_fixed_point(self._place(*_CAR_OUTLINE_M.T))],
            True,
            _OUTLINE,
            1,
            cv2.LINE_AA,
            _SHIFT,
        )
        return canvas

    def _draw_path(self, canvas, path, x_m, y_m, yaw_rad):
        segments = np.stack([path[:-1, :2], path[1:, :2]], axis=1)
        colours = 255.0 * speed_colours(path[:-1, 2], self._full_speed_mps)[:, ::-1]
        for segment, colour in zip(
            _fixed_point(self.to_pixels(segments, x_m, y_m, yaw_rad)), colours.tolist()
        ):
            cv2.polylines(canvas, [segment], False, colour, 3, cv2.LINE_AA, _SHIFT)

    def _pixels_near(self, shapes_m, x_m, y_m, yaw_rad):
        near = np.abs(shapes_m[:, 0] - (x_m, y_m)).max(axis=1) < self._reach_m
        return _fixed_point(self.to_pixels(shapes_m[near], x_m, y_m, yaw_rad))


def _finite_rows(rows, columns):
    rows = np.asarray(rows if rows is not None else (), dtype=float).reshape(-1, columns)
    return rows[np.isfinite(rows).all(axis=1)]


def _in_car_frame(points, x_m, y_m, yaw_rad):
    dx, dy = points[..., 0] - x_m, points[..., 1] - y_m
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    return c * dx + s * dy, c * dy - s * dx


def _in_map(points, x_m, y_m, yaw_rad):
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    return np.stack(
        [x_m + c * points[:, 0] - s * points[:, 1], y_m + s * points[:, 0] + c * points[:, 1]],
        axis=-1,
    )


def _fixed_point(pixels: np.ndarray) -> np.ndarray:
    return np.round(np.clip(pixels, -1e4, 1e4) * 2**_SHIFT).astype(np.int32)
