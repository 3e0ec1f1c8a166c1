"""Roads of straights and arcs with bodies on them: scenes for benchmarks and pictures."""

from __future__ import annotations

from typing import Sequence, Tuple

import numpy as np

from sdc_sim.camera.boxes import Box
from sdc_sim.road.road import Road
from sdc_sim.road.route_generator import generate_route

# A body relative to the car: distance along the route [m], to the left of it [m], kind of the Box.
Actor = Tuple[float, float, str]

TRAFFIC: tuple[Actor, ...] = (
    (14.0, 0.0, "car"),
    (27.0, 0.2, "car"),
    (18.0, 3.5, "car"),
    (40.0, 3.5, "car"),
    (60.0, 0.0, "car"),
    (11.0, -3.4, "pedestrian"),
    (22.0, 7.0, "pedestrian"),
    (32.0, -3.2, "pedestrian"),
    (35.0, 1.8, "obstacle"),
    (24.0, -3.0, "light"),
)
# Length, width and height [m].
_SIZES = {
    "car": (4.7, 2.0, 1.45),
    "pedestrian": (0.45, 0.6, 1.78),
    "obstacle": (1.0, 1.0, 1.0),
    "light": (0.5, 0.5, 4.2),
}
_COLOURS_BGR = ((40, 40, 170), (160, 100, 40), (215, 215, 215), (60, 60, 60), (60, 140, 60))
_FIXED_COLOURS_BGR = {"light": (40, 40, 255), "obstacle": (30, 130, 235)}


def road(*elements: float | tuple[float, float]) -> Road:
    """Return a road from the origin along x.

    Args:
        elements: length of a straight [m], or radius [m] and angle [degrees] of an arc, which is
            positive for a turn to the left
    """
    rows = [
        {"straight_m": one}
        if isinstance(one, (int, float))
        else {
            "left_deg" if one[1] > 0 else "right_deg": abs(one[1]),
            "radius_m": one[0],
            "transition_m": 0.01,
        }
        for one in elements
    ]
    start = {"x_m": 0.0, "y_m": 0.0, "heading_deg": 0.0}
    # The y axis of the rows points to the right.
    points = generate_route({"elements": rows, "start": start, "spacing_m": 1.0})[:, :2]
    return Road(points * (1.0, -1.0))


def pose(road: Road, s_m: float, left_m: float = 0.0) -> tuple[float, float, float]:
    """Return a pose along a road: x [m], y [m] and yaw [rad].

    Args:
        road: the road
        s_m: distance along the route [m]
        left_m: distance to the left of the route [m]
    """
    points, left = road.at(np.array([s_m]))
    x, y = points[0] + left_m * left[0]
    return float(x), float(y), float(np.arctan2(-left[0, 0], left[0, 1]))


def traffic(road: Road, s_m: float, actors: Sequence[Actor] = TRAFFIC) -> list[Box]:
    """Return boxes on the road ahead of a position.

    Args:
        road: the road
        s_m: position of the car along the route [m]
        actors: the bodies; cars in the left lane and traffic lights face the car
    """
    boxes = []
    for k, (ahead_m, left_m, kind) in enumerate(actors):
        x, y, yaw = pose(road, s_m + ahead_m, left_m)
        oncoming = kind == "light" or (kind == "car" and left_m > 2.0)
        colour = _FIXED_COLOURS_BGR.get(kind, _COLOURS_BGR[k % len(_COLOURS_BGR)])
        yaw += np.pi if oncoming else 0.0
        boxes.append(Box(x, y, yaw, *_SIZES[kind], colour_bgr=colour, kind=kind))
    return boxes
