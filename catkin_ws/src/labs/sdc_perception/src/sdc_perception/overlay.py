"""Draw what the detectors found into camera pictures (H, W, 3 or 4), BGR first."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

from sdc_perception.ground_plane import GroundPlane
from sdc_perception.lane_curve import STEP_M
from sdc_perception.lane_tracker import FoundMarkings, TrackedLane
from sdc_perception.light_detection import NAMES, SeenLight
from sdc_perception.obstacle_detection import SeenBody
from sdc_perception.vehicle_frame import in_vehicle_frame

# Right edge, dashes, left edge, and the lane's centre: visible and beyond (BGR).
LINES_BGR = ((60, 60, 255), (0, 220, 255), (255, 120, 60))
_CENTRE_BGR, _BEYOND_BGR = (60, 220, 60), (150, 150, 150)
_NEAREST_M = 1.5
_LIGHTS_BGR = ((60, 60, 255), (0, 220, 255), (90, 255, 60))
_BODIES_BGR = {"car": (255, 160, 60), "pedestrian": (255, 80, 255)}
_OTHER_BGR = (60, 180, 255)
_WHITE_BGR = (255, 255, 255)


def draw_lane(
    image: np.ndarray,
    ground: GroundPlane,
    pose: tuple[float, float, float],
    lane: TrackedLane | None,
    found: FoundMarkings | None,
) -> np.ndarray:
    """Return a BGR picture (H, W, 3) with the markings, the lane's centre and its numbers."""
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
    state = f"confidence {lane.confidence:.2f}  visible {lane.visible_m:.0f} m"
    for row, line_text in enumerate((text, state)):
        write(picture, line_text, (12, 26 + 24 * row), 0.55)
    return picture


def draw_dot(picture: np.ndarray, pixel: np.ndarray, colour: tuple[int, int, int]) -> None:
    """Draw a dot at a pixel (2,), unless it is NaN or far outside."""
    if np.isfinite(pixel).all() and np.all(np.abs(pixel) < 1e4):
        centre = (int(round(float(pixel[0]))), int(round(float(pixel[1]))))
        cv2.circle(picture, centre, 2, colour, -1, cv2.LINE_AA)


def write(
    picture: np.ndarray,
    text: str,
    place: tuple[int, int],
    size: float,
    colour: tuple[int, int, int] = _WHITE_BGR,
) -> None:
    """Write a text with a black edge; it begins at a pixel (column, row)."""
    font, smooth = cv2.FONT_HERSHEY_SIMPLEX, cv2.LINE_AA
    cv2.putText(picture, text, place, font, size, (0, 0, 0), 3, smooth)
    cv2.putText(picture, text, place, font, size, colour, 1, smooth)


def draw_lights(image: np.ndarray, lights: Sequence[SeenLight]) -> np.ndarray:
    """Return a BGR picture (H, W, 3) with a box, the colour and the distance of each light."""
    picture = np.ascontiguousarray(image[..., :3])
    for light in lights:
        colour = _LIGHTS_BGR[light.state]
        _box(picture, light.box, colour, f"{NAMES[light.state]} {light.x_m:.0f} m", above=True)
        if light.foot is not None:
            foot = (round(light.foot[0]), round(light.foot[1]))
            cv2.drawMarker(picture, foot, colour, cv2.MARKER_TILTED_CROSS, 7, 1, cv2.LINE_AA)
    return picture


def draw_obstacles(image: np.ndarray, bodies: Sequence[SeenBody]) -> np.ndarray:
    """Return a BGR picture (H, W, 3) with a box, the kind and the distance of each body."""
    picture = np.ascontiguousarray(image[..., :3])
    for body in bodies:
        colour = _BODIES_BGR.get(body.kind, _OTHER_BGR)
        _box(picture, body.box, colour, f"{body.kind} {body.x_m:.0f} m", above=False)
    return picture


def _box(
    picture: np.ndarray,
    box: tuple[float, float, float, float],
    colour: tuple[int, int, int],
    text: str,
    above: bool,
) -> None:
    left, top, right, bottom = box
    low = (math.floor(left) - 2, math.floor(top) - 2)
    high = (math.ceil(right) + 2, math.ceil(bottom) + 2)
    cv2.rectangle(picture, low, high, colour, 1)
    corner = (low[0], low[1] - 5 if above else high[1] + 14)
    write(picture, text, corner, 0.45, colour)
