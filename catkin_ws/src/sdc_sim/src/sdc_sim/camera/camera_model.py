"""Pinhole model of the front camera over a flat ground.

Pixel centres are at integer coordinates. The principal point is (w/2, h/2) and
fx = fy = w / (2 tan(fov/2)), as in the camera_info of the CARLA bridge. The optical frame is that
of REP 103: x right, y down, z along the view.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

# Points nearer than this along the view have no pixel.
_LEAST_DEPTH_M = 0.01


@dataclass(frozen=True)
class CameraModel:
    """Pinhole camera on a car whose body stays level on the ground plane z = 0."""

    width: int = 640  # width of the picture [px]
    height: int = 480  # height of the picture [px]
    fov_rad: float = np.pi / 2.0  # horizontal field of view [rad]
    mount_x_m: float = 0.7  # position ahead of the vehicle's centre [m]
    mount_z_m: float = 1.7  # height above the ground [m]
    pitch_rad: float = np.pi / 360.0  # downward tilt of the view [rad]

    def __post_init__(self):
        if not (self.width >= 16 and self.height >= 16 and self.width % 2 == 0):
            raise ValueError(
                f"camera: picture size {self.width} x {self.height} is not supported; "
                "use an even width and at least 16 x 16"
            )

    @cached_property
    def focal_px(self) -> float:
        """Return the focal length fx = fy [px]."""
        return float(self.width / (2.0 * np.tan(self.fov_rad / 2.0)))

    @cached_property
    def horizon_px(self) -> float:
        """Return the row of the horizon, with its fraction [px]."""
        return self.height / 2.0 - self.focal_px * np.tan(self.pitch_rad)

    @cached_property
    def first_ground_row(self) -> int:
        """Return the first row that shows more ground than sky."""
        return min(max(0, math.floor(self.horizon_px + 0.5)), self.height - 1)

    def intrinsic_matrix(self) -> np.ndarray:
        """Return the camera matrix K (3, 3) [px]."""
        f = self.focal_px
        return np.array([[f, 0.0, self.width / 2.0], [0.0, f, self.height / 2.0], [0.0, 0.0, 1.0]])

    def position_in_map(self, x_m: float, y_m: float, yaw_rad: float) -> np.ndarray:
        """Return the position (3,) of the camera in the map for a pose of the vehicle [m]."""
        return np.array(
            [
                x_m + self.mount_x_m * np.cos(yaw_rad),
                y_m + self.mount_x_m * np.sin(yaw_rad),
                self.mount_z_m,
            ]
        )

    def map_from_optical(self, yaw_rad: float) -> np.ndarray:
        """Return the rotation (3, 3) from the optical frame to the map for a heading [rad]."""
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        map_from_vehicle = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        c, s = np.cos(self.pitch_rad), np.sin(self.pitch_rad)
        return map_from_vehicle @ np.array([[0.0, -s, c], [-1.0, 0.0, 0.0], [0.0, -c, -s]])

    def project(
        self, points_m: np.ndarray, x_m: float, y_m: float, yaw_rad: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the pixels of points (N, 3) of the map for a pose of the vehicle.

        Returns:
            pixels (N, 2) as (u, v), NaN for points behind the camera, and the mask (N,) of the
            points in front of it
        """
        points = np.asarray(points_m, float).reshape(-1, 3)
        optical = (points - self.position_in_map(x_m, y_m, yaw_rad)) @ self.map_from_optical(
            yaw_rad
        )
        front = optical[:, 2] > _LEAST_DEPTH_M
        pixels = np.full((len(optical), 2), np.nan)
        pixels[front] = self.focal_px * optical[front, :2] / optical[front, 2:] + [
            self.width / 2.0,
            self.height / 2.0,
        ]
        return pixels, front
