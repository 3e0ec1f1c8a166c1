"""The picture of docs/camera.md: straight, roundabout, tight turn, crossing, traffic and dusk.

python3 -m sdc_experiments.camera_strip FILE.png
"""

from __future__ import annotations

import sys

import cv2
import numpy as np

from sdc_sim.camera.example_scenes import TRAFFIC, pose, route, traffic
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import Road

_STRAIGHTS_AND_TURNS = (
    *(("s", 80), ("l", 40, 1.2), ("s", 60), ("r", 25, 1.6), ("s", 120), ("r", 60, 0.9)),
    *(("l", 20, 1.8), ("s", 90), ("l", 4, 1.57), ("s", 80), ("r", 15, 1.57), ("s", 150)),
)


def strip() -> np.ndarray:
    """Return a strip of six pictures (960, 1920, 3) BGR."""
    curvy = Road(route(*_STRAIGHTS_AND_TURNS))
    ring = Road(route(("s", 60), ("r", 12, 0.8), ("l", 20, 5.6), ("r", 12, 0.8), ("s", 60)))
    crossing = Road(route(("s", 120), ("l", 15, 4.71), ("s", 120)))
    frames = [
        Renderer(road).render(*pose(road, s_m), traffic(road, s_m, actors), light)[..., :3]
        for road, s_m, actors, light in (
            (curvy, 30.0, (), 1.0),
            (ring, 75.0, TRAFFIC[1:2], 1.0),
            (curvy, 521.0, TRAFFIC[3:4], 1.0),
            (crossing, 105.0, (), 1.0),
            (curvy, 190.0, TRAFFIC, 1.0),
            (curvy, 250.0, TRAFFIC, 0.25),
        )
    ]
    return np.vstack([np.hstack(frames[:3]), np.hstack(frames[3:])])


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("Usage: python3 -m sdc_experiments.camera_strip FILE.png")
    if not cv2.imwrite(sys.argv[1], strip()):
        sys.exit(f"camera_strip: cannot write {sys.argv[1]}")
