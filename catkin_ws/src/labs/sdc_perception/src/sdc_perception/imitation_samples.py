"""What the steering network sees and learns: a view of the road, an arc and a speed."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

# Height and width of the view [px]: the part of the picture of 640 x 480 below the horizon and
# above the bonnet, with a fifth of the pixels in each direction.
VIEW_SHAPE = (40, 128)
_PICTURE_SHAPE = (480, 640)
_FIRST_ROW, _LAST_ROW = 240, 440
LOOK_AHEAD_S = 0.8  # the driver looks at the place where the car is after this time
SHORTEST_LOOK_AHEAD_M = 4.0  # least distance of that place
# The network answers what the driver did so much later: the steering moves with a delay.
REACTION_S = 0.2
# Distance of the rear axle behind the centre of the car.
REAR_M = 1.435


class Answer(NamedTuple):
    """What a driver does at a picture."""

    curvature_1pm: float  # curvature of the arc of the rear axle, positive left [1/m]
    speed_mps: float  # target speed [m/s]


def road_view(picture: np.ndarray) -> np.ndarray:
    """Return the view (40, 128, 3) of the road in a picture (480, 640, 3 or 4) of the camera.

    Raises:
        ValueError: the picture has another size
    """
    if picture.shape[:2] != _PICTURE_SHAPE:
        height, width = picture.shape[:2]
        raise ValueError(f"a picture must have 640 x 480 pixels, got {width} x {height}")
    road = picture[_FIRST_ROW:_LAST_ROW, :, :3]
    return cv2.resize(road, VIEW_SHAPE[::-1], interpolation=cv2.INTER_AREA)


class DrivenLine:
    """The line of the rear axle of a recorded drive, and the answers that lead along it.

    Attributes:
        poses: (N, 3) poses of the rear axle: x [m], y [m], yaw [rad]
        speeds_mps: (N,) speeds [m/s]
    """

    def __init__(self, times_s: np.ndarray, poses: np.ndarray, speeds_mps: np.ndarray):
        """Take the record of a drive.

        Args:
            times_s: (N,) times, ascending [s]
            poses: (N, 3) poses of the centre of the car: x [m], y [m], yaw [rad]
            speeds_mps: (N,) speeds [m/s]
        """
        x, y, yaw = np.asarray(poses, float).T
        self.poses = np.column_stack([x - REAR_M * np.cos(yaw), y - REAR_M * np.sin(yaw), yaw])
        self.speeds_mps = np.asarray(speeds_mps, float)
        self._times_s = np.asarray(times_s, float)
        self._s_m = np.cumsum(
            np.hypot(*np.diff(self.poses[:, :2], axis=0, prepend=self.poses[:1, :2]).T)
        )
        steps_m = np.maximum(np.gradient(self._s_m), 1e-3)
        self._curvatures_1pm = np.gradient(np.unwrap(yaw)) / steps_m

    def has_answer(self, i: int) -> bool:
        """Return whether the drive goes on for the look-ahead distance after row i."""
        return bool(self._s_m[-1] - self._s_m[i] > self._look_ahead_m(i))

    def displaced(self, i: int, left_m: float, turned_rad: float) -> tuple[float, float, float]:
        """Return the pose of the centre of a car beside row i: x [m], y [m], yaw [rad]."""
        x, y, yaw = self._rear(i, left_m, turned_rad)
        return x + REAR_M * math.cos(yaw), y + REAR_M * math.sin(yaw), yaw

    def answer(self, i: int, left_m: float = 0.0, turned_rad: float = 0.0) -> Answer:
        """Return the answer at row i, for a car that is beside the line.

        On the line it is what the driver did. Beside the line, it is turned towards a place of the
        line ahead by as much more as the arc to this place is tighter than on the line.

        Args:
            i: row of the record
            left_m: distance of the car to the left of the line [m]
            turned_rad: heading of the car relative to the recorded one, positive left [rad]
        """
        back_1pm = self._arc(i, left_m, turned_rad) - self._arc(i, 0.0, 0.0)
        soon_s, later_s = self._times_s[i] + REACTION_S, self._times_s[i] + LOOK_AHEAD_S
        driven_1pm = float(np.interp(soon_s, self._times_s, self._curvatures_1pm))
        speed = float(np.interp(later_s, self._times_s, self.speeds_mps))
        return Answer(driven_1pm + back_1pm, speed)

    def _arc(self, i: int, left_m: float, turned_rad: float) -> float:
        """Return the curvature of the arc from beside row i to the line ahead [1/m]."""
        x, y, yaw = self._rear(i, left_m, turned_rad)
        s_m = self._s_m[i] + self._look_ahead_m(i)
        dx = float(np.interp(s_m, self._s_m, self.poses[:, 0])) - x
        dy = float(np.interp(s_m, self._s_m, self.poses[:, 1])) - y
        left = dy * math.cos(yaw) - dx * math.sin(yaw)
        return 2.0 * left / (dx * dx + dy * dy)

    def _look_ahead_m(self, i: int) -> float:
        return max(SHORTEST_LOOK_AHEAD_M, LOOK_AHEAD_S * float(self.speeds_mps[i]))

    def _rear(self, i: int, left_m: float, turned_rad: float) -> tuple[float, float, float]:
        x, y, yaw = self.poses[i].tolist()
        return x - left_m * math.sin(yaw), y + left_m * math.cos(yaw), yaw + turned_rad


def arc_path(pose: tuple[float, float, float], answer: Answer) -> np.ndarray:
    """Return the path (N, 3) of x [m], y [m] and speed [m/s] of the centre of the car.

    It begins behind the car, and ends 15 m ahead of it. The rear axle is on the arc.

    Args:
        pose: pose of the centre: x [m], y [m], yaw [rad]
        answer: arc and speed
    """
    x, y, yaw = pose
    s_m = np.arange(-4.0, 15.5)
    headings = answer.curvature_1pm * s_m
    # The chord of an arc of this length; np.sinc(t) is sin(pi t) / (pi t).
    chords_m = s_m * np.sinc(0.5 * headings / np.pi)
    ahead_m = chords_m * np.cos(0.5 * headings) + REAR_M * (np.cos(headings) - 1.0)
    left_m = chords_m * np.sin(0.5 * headings) + REAR_M * np.sin(headings)
    c, s = math.cos(yaw), math.sin(yaw)
    speeds = np.full(len(s_m), answer.speed_mps)
    return np.column_stack([x + c * ahead_m - s * left_m, y + s * ahead_m + c * left_m, speeds])
