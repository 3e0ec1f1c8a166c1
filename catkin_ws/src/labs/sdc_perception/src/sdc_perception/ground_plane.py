"""Projection between pixels of the front camera and the flat ground around the vehicle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sdc_common.validation import check_finite

_LEAST_DEPTH_M = np.float32(1e-3)


@dataclass(frozen=True)
class MountingPose:
    """Pose of the camera on the vehicle."""

    x_m: float  # position ahead of the vehicle's centre [m]
    z_m: float  # height above the ground [m]
    pitch_rad: float  # downward tilt of the view [rad]

    def __post_init__(self):
        check_finite(**vars(self))


class GroundPlane:
    """Pinhole camera over the plane z = 0 of the vehicle frame (x forward, y left).

    Reference: Hartley and Zisserman, Multiple View Geometry, 2nd edition, section 8.1.1: a plane
    and its picture are related by a homography.
    """

    def __init__(self, intrinsic: np.ndarray, mount: MountingPose):
        """Compute the homography.

        Args:
            intrinsic: camera matrix K (3, 3) of camera_info [px]
            mount: pose of the camera on the vehicle
        """
        self._to_picture = np.asarray(intrinsic, float) @ optical_frame(mount)
        self._to_ground = np.linalg.inv(self._to_picture)

    def pixels(self, points_m: np.ndarray) -> np.ndarray:
        """Return the pixels (..., 2) of ground points (..., 2); NaN behind the camera."""
        return projected(self._to_picture, points_m)

    def pixels_along(
        self, points_m: np.ndarray, directions: np.ndarray, distances_m: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the pixels at distances from ground points: columns (N, M) and rows (N, M).

        Before the division by the depth, equal steps on the ground are equal steps in the picture.

        Args:
            points_m: ground points (N, 2) [m]
            directions: unit vectors (N, 2)
            distances_m: distances (N, M) along them [m]
        """
        start = points_m @ self._to_picture[:, :2].T + self._to_picture[:, 2]
        step = directions @ self._to_picture[:, :2].T
        distances = distances_m.astype(np.float32)
        column, row, depth = (
            origin + distances * change
            for origin, change in zip(
                start.T[..., None].astype(np.float32), step.T[..., None].astype(np.float32)
            )
        )
        nearer = 1.0 / np.maximum(depth, _LEAST_DEPTH_M)
        return column * nearer, row * nearer

    def points(self, pixels: np.ndarray) -> np.ndarray:
        """Return the ground points (..., 2) [m] of pixels (..., 2); NaN above the horizon."""
        # The third coordinate of the inverse has the sign of the depth.
        return projected(self._to_ground, pixels)


def optical_frame(mount: MountingPose) -> np.ndarray:
    """Return the matrix (3, 3) from (x, y, 1) of a ground point to the optical frame [m].

    The optical frame begins in the camera: its x axis points to the right, y down, z ahead along
    the view. With the pitch, z points a little down, and y a little backwards.

    Args:
        mount: pose of the camera on the vehicle, whose frame has x forward and y to the left
    """
    c, s = math.cos(mount.pitch_rad), math.sin(mount.pitch_rad)
    # TODO 1: a ground point in the optical frame (until then: right, down, ahead = np.eye(3))
    right = [0.0, -1.0, 0.0]
    down = [-s, 0.0, s * mount.x_m + c * mount.z_m]
    ahead = [c, 0.0, -c * mount.x_m + s * mount.z_m]
    # ----------------------------------------------------------------------------
    return np.array([right, down, ahead])


def projected(homography: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return points (..., 2) after a homography (3, 3); NaN where their depth is not positive."""
    mapped = points @ homography[:, :2].T + homography[:, 2]
    depth = mapped[..., 2:]
    with np.errstate(divide="ignore", invalid="ignore"):
        # TODO 2: what the pinhole shows, NaN behind it (until then: return mapped[..., :2])
        return np.where(depth > 1e-9, mapped[..., :2] / depth, np.nan)
        # ----------------------------------------------------------------------------
