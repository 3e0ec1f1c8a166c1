"""Draw what the lane detector found into the picture."""

from __future__ import annotations

import math

import cv2
import numpy as np

from sdc_perception.ground_plane import GroundPlane
from sdc_perception.lane_curve import STEP_M
from sdc_perception.lane_tracker import FoundMarkings, TrackedLane
from sdc_perception.vehicle_frame import in_vehicle_frame

# Right edge, dashes, left edge, and the lane's centre: visible and beyond (BGR).
LINES_BGR = ((60, 60, 255), (0, 220, 255), (255, 120, 60))
_CENTRE_BGR, _BEYOND_BGR = (60, 220, 60), (150, 150, 150)
_NEAREST_M = 1.5


def draw_lane(
    image: np.ndarray,
    ground: GroundPlane,
    pose: tuple[float, float, float],
    lane: TrackedLane | None,
    found: FoundMarkings | None,
) -> np.ndarray:
    """Return a BGR picture (H, W, 3) with the markings, the lane's centre and its numbers.

    Args:
        image: camera picture (H, W, 3 or 4), BGR first
        ground: projection of the camera
        pose: x [m], y [m] and yaw [rad] of the car
        lane: the lane, None if there is none
        found: the markings
    """
    picture = np.ascontiguousarray(image[..., :3])
    if lane is None:
        cv2.putText(picture, "no lane", (12, 28), cv2.FONT_HERSHEY_SIMPLEX, 0.7, (0, 0, 255), 2)
        return picture
    centre = in_vehicle_frame(lane.points_m, pose)
    s_m = lane.first_m + STEP_M * np.arange(len(centre))
    for s_point, pixel in zip(s_m.tolist(), ground.pixels(centre)):
        if s_point > _NEAREST_M:
            draw_dot(picture, pixel, _CENTRE_BGR if s_point < lane.visible_m else _BEYOND_BGR)
    if found is not None:
        for line, pixel in zip(found.line.tolist(), ground.pixels(found.points_m)):
            draw_dot(picture, pixel, LINES_BGR[line])
    text = (
        f"offset {lane.offset_m:+.2f} m  heading {math.degrees(lane.heading_error_rad):+.1f} deg  "
        f"curvature {lane.curvature_1pm:+.3f} 1/m"
    )
    more = f"confidence {lane.confidence:.2f}  visible {lane.visible_m:.0f} m"
    for row, line_text in enumerate((text, more)):
        at = (12, 26 + 24 * row)
        cv2.putText(picture, line_text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.55, (0, 0, 0), 3)
        cv2.putText(picture, line_text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.55, (255, 255, 255), 1)
    return picture


def draw_dot(picture: np.ndarray, pixel: np.ndarray, colour: tuple[int, int, int]) -> None:
    """Draw a dot at a pixel (2,), unless it is NaN or far outside."""
    if np.isfinite(pixel).all() and np.all(np.abs(pixel) < 1e4):
        centre = (int(round(float(pixel[0]))), int(round(float(pixel[1]))))
        cv2.circle(picture, centre, 2, colour, -1, cv2.LINE_AA)
