"""The picture of docs/camera.md: straight, roundabout, tight turn, crossing, traffic and dusk.

python3 -m sdc_experiments.camera_strip FILE.png
"""

from __future__ import annotations

import sys

import cv2
import numpy as np

from sdc_experiments.camera_scenes import TRAFFIC, pose, road, traffic
from sdc_sim.camera.renderer import Renderer

_CURVY = (
    *(80, (40, 69), 60, (25, -92), 120, (60, -52), (20, 103)),
    *(90, (4, 90), 80, (15, -90), 150),
)


def strip() -> np.ndarray:
    """Return a strip of six pictures (960, 1920, 3) BGR."""
    curvy, crossing = road(*_CURVY), road(120, (15, 270), 120)
    ring = road(60, (12, -46), (20, 321), (12, -46), 60)
    frames = [
        Renderer(one).render(*pose(one, s_m), traffic(one, s_m, actors), light)[..., :3]
        for one, s_m, actors, light in (
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
