"""Draw what each stage of the detector makes of a picture."""

from __future__ import annotations

from typing import Callable

import cv2
import numpy as np

from sdc_perception.ground_plane import GroundPlane
from sdc_perception.ground_tracks import Pose
from sdc_perception.lane_acquisition import LaneGuess
from sdc_perception.lane_detection import LaneDetector
from sdc_perception.overlay import LINES_BGR, draw_dot, write

_GRID_BGR, _POINT_BGR = (0, 255, 255), (255, 0, 255)
_NEAREST_M = 3.0  # the grid begins here, ahead of the car
_FARTHEST_M = 40.0  # the grid ends here
_LABELLED_M = 15.0  # nearer lines have a label
_SIDE_M = 6.0  # width of the grid to each side
_BELOW = 12, 466  # where a text begins, near the lower edge [px]


def draw_ground(picture: np.ndarray, detector: LaneDetector, pose: Pose) -> None:
    """Draw a grid on the ground: 1 m to the sides, 5 m ahead."""
    ahead = np.arange(_NEAREST_M, _FARTHEST_M, 0.5)
    for y in np.arange(-_SIDE_M, _SIDE_M + 0.5):
        _draw_line(picture, detector.ground, np.column_stack([ahead, np.full(len(ahead), y)]))
    for x in np.arange(5.0, _FARTHEST_M, 5.0):
        _draw_line(picture, detector.ground, np.array([(x, -_SIDE_M), (x, _SIDE_M)]))
        pixel = detector.ground.pixels(np.array([x, -_SIDE_M]))
        if x <= _LABELLED_M and np.all(np.abs(pixel) < 1e4):
            corner = int(pixel[0]) + 4, int(pixel[1]) + 4
            cv2.putText(picture, f"{x:.0f} m", corner, cv2.FONT_HERSHEY_SIMPLEX, 0.45, _GRID_BGR, 1)


def draw_markings(picture: np.ndarray, detector: LaneDetector, pose: Pose) -> None:
    """Draw the points that are in the middle of a marking."""
    points_m = detector.marking_points(picture)
    for pixel in detector.ground.pixels(points_m):
        draw_dot(picture, pixel, _POINT_BGR)
    write(picture, f"{len(points_m)} points on markings", _BELOW, 0.5)


def draw_guess(picture: np.ndarray, detector: LaneDetector, pose: Pose) -> None:
    """Draw the lines of the lane that most points are on."""
    guess = detector.guess(picture)
    if guess is None:
        write(picture, "no lane", _BELOW, 0.5)
        return
    x = np.arange(_NEAREST_M, 18.0, 0.25)
    for line_m, colour in zip(detector.lines_m, LINES_BGR):
        for pixel in detector.ground.pixels(np.column_stack([x, _centre_m(guess, x) + line_m])):
            draw_dot(picture, pixel, colour)
    write(
        picture,
        f"{guess.inliers} points  offset {guess.offset_m:+.2f} m  "
        f"heading {guess.heading_error_rad:+.2f} rad  curvature {guess.curvature_1pm:+.3f} 1/m",
        _BELOW,
        0.5,
    )


def draw_tracking(picture: np.ndarray, detector: LaneDetector, pose: Pose) -> None:
    """Draw the lane as it is known from all pictures, and the markings in this one."""
    lane = detector.detect(picture, pose)
    picture[..., :3] = detector.drawn(picture, pose, lane)


STAGES: dict[str, Callable[[np.ndarray, LaneDetector, Pose], None]] = {
    "ground": draw_ground,
    "markings": draw_markings,
    "guess": draw_guess,
    "tracking": draw_tracking,
}


def _centre_m(guess: LaneGuess, x: np.ndarray) -> np.ndarray:
    return -guess.offset_m + guess.heading_error_rad * x + 0.5 * guess.curvature_1pm * x * x


def _draw_line(picture: np.ndarray, ground: GroundPlane, points_m: np.ndarray) -> None:
    pixels = ground.pixels(points_m)
    near = np.isfinite(pixels).all(axis=1) & (np.abs(pixels) < 1e4).all(axis=1)
    corners = np.round(pixels[near]).astype(np.int32)
    cv2.polylines(picture, [corners], False, _GRID_BGR, 1, cv2.LINE_AA)
