"""Draw the stages of the lane detector for docs/labs/perception.md.

    python3 -m sdc_perception.study.pictures [FILE]

The picture shows a bend of the packaged town: ground plane, markings and guessed lane.
"""

from __future__ import annotations

import math
import os
import sys

import cv2
import numpy as np
import rospkg

from sdc_common.routes.waypoint_file import load_waypoints
from sdc_perception.lane_detection import DetectorSettings, LaneDetector
from sdc_perception.stage_pictures import STAGES
from sdc_perception.study.drives import lab_parameters
from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import Road

_AT_M = 150.0
_FIRST_ROW = 170
_SCALE = 0.6


def stage_pictures() -> np.ndarray:
    """Return the pictures of all stages next to each other, (H, W, 3) BGR."""
    folder = rospkg.RosPack().get_path("sdc_common")
    road = Road(load_waypoints(os.path.join(folder, "data", "waypoints.csv")))
    points, left = road.at(np.array([_AT_M]))
    (x, y), (left_x, left_y) = points[0], left[0]
    pose = float(x), float(y), math.atan2(-left_x, left_y)
    picture = Renderer(road).render(*pose)
    settings = DetectorSettings.read(lab_parameters("lane_detector").__getitem__)
    detector = LaneDetector(settings, CameraModel().intrinsic_matrix())
    drawn = []
    for stage in ("ground", "markings", "guess"):
        drawn.append(picture.copy())
        STAGES[stage](drawn[-1], detector, pose)
    pictures = np.hstack([one[_FIRST_ROW:] for one in drawn])[..., :3]
    return cv2.resize(pictures, None, fx=_SCALE, fy=_SCALE, interpolation=cv2.INTER_AREA)


if __name__ == "__main__":
    cv2.imwrite(sys.argv[1] if len(sys.argv) > 1 else "perception_stages.png", stage_pictures())
