"""The configuration of RViz shows topics that the world and the stack publish."""

import re
from pathlib import Path

from sdc_sim.ros.bridge_versions import BRIDGE_VERSIONS

PACKAGE = Path(__file__).resolve().parents[1]
EGO = "/carla/ego_vehicle"
DEFAULT = BRIDGE_VERSIONS["0.9.3"]


def test_displays_and_tools_use_topics_that_exist():
    configured = set(re.findall(r"Topic: (/\S+)", (PACKAGE / "rviz" / "drive.rviz").read_text()))
    shown = re.findall(r'"(/show/\w+)"', (PACKAGE / "scripts" / "show.py").read_text())
    lidars = [EGO + DEFAULT.sensors[name].topic for name in ("lidar", "planar_lidar")]
    known = {*shown, *lidars, EGO + DEFAULT.front.image, EGO + "/odometry"}
    known |= {"/carla/markers", "/camera/lane_mask", "/initialpose", "/clicked_point"}
    assert configured == known
