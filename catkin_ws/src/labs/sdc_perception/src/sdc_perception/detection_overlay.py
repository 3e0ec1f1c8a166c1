"""Draw traffic lights and obstacles into the picture."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

from sdc_perception.light_detection import NAMES, SeenLight
from sdc_perception.obstacle_detection import SeenBody

_LIGHTS_BGR = ((60, 60, 255), (0, 220, 255), (90, 255, 60))
_BODIES_BGR = {"car": (255, 160, 60), "pedestrian": (255, 80, 255)}
_OTHER_BGR = (60, 180, 255)


def draw_lights(image: np.ndarray, lights: Sequence[SeenLight]) -> np.ndarray:
    """Return a BGR picture (H, W, 3) with a box, the colour and the distance of each light.

    Args:
        image: camera picture (H, W, 3 or 4), BGR first
        lights: the lights
    """
    picture = np.ascontiguousarray(image[..., :3])
    for light in lights:
        colour = _LIGHTS_BGR[light.state]
        _box(picture, light.box, colour, f"{NAMES[light.state]} {light.x_m:.0f} m", above=True)
        if light.foot is not None:
            foot = (round(light.foot[0]), round(light.foot[1]))
            cv2.drawMarker(picture, foot, colour, cv2.MARKER_TILTED_CROSS, 7, 1, cv2.LINE_AA)
    return picture


def draw_obstacles(image: np.ndarray, bodies: Sequence[SeenBody]) -> np.ndarray:
    """Return a BGR picture (H, W, 3) with a box, the kind and the distance of each body.

    Args:
        image: camera picture (H, W, 3 or 4), BGR first
        bodies: the bodies
    """
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
    at = (low[0], low[1] - 5 if above else high[1] + 14)
    cv2.putText(picture, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.45, (0, 0, 0), 3, cv2.LINE_AA)
    cv2.putText(picture, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv2.LINE_AA)
