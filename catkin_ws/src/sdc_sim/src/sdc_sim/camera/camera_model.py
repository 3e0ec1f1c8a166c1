"""The geometry of the front camera: a pinhole camera over a flat world.

`CameraModel` says where a point of the map falls in the picture. Pixel centres are at integer coordinates; the principal
point is (w/2, h/2) and fx = fy = w / (2 tan(fov/2)), as the CARLA bridge gives them in its camera_info. The optical frame is
that of REP 103: x right, y down, z along the view.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class CameraModel:
    """A pinhole camera on a car that stands level on the ground plane z = 0.

    `mount_x_m` ahead of the vehicle's centre, `mount_z_m` above the ground, `pitch_rad` positive nose down.
    """

    width: int = 640
    height: int = 480
    fov_rad: float = np.pi / 2.0
    mount_x_m: float = 0.7
    mount_z_m: float = 1.7
    pitch_rad: float = np.pi / 360.0

    def __post_init__(self):
        if not (self.width >= 16 and self.height >= 16 and self.width % 2 == 0):
            raise ValueError(
                f"picture of {self.width} x {self.height}: at least 16 x 16 with an even width"
            )
        if not (0.1 < self.fov_rad < 2.4 and self.mount_z_m > 0.1 and abs(self.pitch_rad) < 0.3):
            raise ValueError(
                "camera: fov_rad in 0.1..2.4, mount_z_m above 0.1, pitch_rad within 0.3"
            )

    @property
    def focal_px(self) -> float:
        """fx = fy, pixels."""
        return float(self.width / (2.0 * np.tan(self.fov_rad / 2.0)))

    @property
    def horizon_px(self) -> float:
        """Row of the horizon, pixels (fractional)."""
        return self.height / 2.0 - self.focal_px * np.tan(self.pitch_rad)

    @property
    def first_ground_row(self) -> int:
        """The first row with more ground than sky in it, pixels."""
        return min(max(0, math.floor(self.horizon_px + 0.5)), self.height - 1)

    def intrinsic_matrix(self) -> np.ndarray:
        """K (3, 3), pixels."""
        f = self.focal_px
        return np.array([[f, 0.0, self.width / 2.0], [0.0, f, self.height / 2.0], [0.0, 0.0, 1.0]])

    def vehicle_from_optical(self) -> np.ndarray:
        """Rotation (3, 3) that turns a vector of the optical frame into the vehicle frame (x forward, z up)."""
        c, s = np.cos(self.pitch_rad), np.sin(self.pitch_rad)
        return np.array([[0.0, -s, c], [-1.0, 0.0, 0.0], [0.0, -c, -s]])

    def position_in_map(self, x_m: float, y_m: float, yaw_rad: float) -> np.ndarray:
        """Position (3,) of the camera in the map for a vehicle at that pose, metres."""
        return np.array(
            [
                x_m + self.mount_x_m * np.cos(yaw_rad),
                y_m + self.mount_x_m * np.sin(yaw_rad),
                self.mount_z_m,
            ]
        )

    def optical_from_map(self, points_m, x_m: float, y_m: float, yaw_rad: float) -> np.ndarray:
        """Points (..., 3) of the map in the optical frame of a vehicle at that pose, metres."""
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        map_from_vehicle = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        offset = np.asarray(points_m, float) - self.position_in_map(x_m, y_m, yaw_rad)
        return offset @ (map_from_vehicle @ self.vehicle_from_optical())

    def project(self, points_m, x_m: float, y_m: float, yaw_rad: float) -> tuple:
        """Pixels (N, 2) as (u, v) of `points_m` (N, 3) in the map, and the mask (N,) of those in front.

        Pixels of points that are not in front (less than 1 cm along the view) are NaN.
        """
        p = self.optical_from_map(np.asarray(points_m, float).reshape(-1, 3), x_m, y_m, yaw_rad)
        front = p[:, 2] > 0.01
        pixels = np.full((len(p), 2), np.nan)
        pixels[front] = self.focal_px * p[front, :2] / p[front, 2:] + [
            self.width / 2.0,
            self.height / 2.0,
        ]
        return pixels, front
