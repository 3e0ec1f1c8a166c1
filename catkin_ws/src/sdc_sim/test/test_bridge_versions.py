"""The topics of the bridge: those that generations.test checks, and those that RViz shows."""

import re
from pathlib import Path

import pytest
import yaml

from sdc_sim.ros.bridge_versions import BRIDGE_VERSIONS

EGO = "/carla/hero"
TABLE = Path(__file__).with_name("data") / "bridge_topics.yaml"
TOPICS = yaml.safe_load(TABLE.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", ["0.9.3", "0.9.5", "0.9.11"])
def test_version_has_its_topics_and_its_command(name):
    version, table = BRIDGE_VERSIONS[name], TOPICS[name]
    cameras = {camera: getattr(version, camera) for camera in ("front", "view", "spectator")}
    pictures = {camera: EGO + names.image for camera, names in cameras.items() if names}
    assert pictures == table["pictures"]
    assert version.control_class._type == table["command"]
    topics = {one if one.startswith("/carla/") else EGO + one for one in version.topics}
    topics |= {"/carla/map", *([EGO + "/spectator_pose"] if version.spectator else [])}
    assert topics == {*table["published"], *table.get("subscribed", ())}


def test_displays_and_tools_use_topics_that_exist():
    package = Path(__file__).resolve().parents[1]
    ego, default = "/carla/ego_vehicle", BRIDGE_VERSIONS["0.9.3"]
    configured = set(re.findall(r"Topic: (/\S+)", (package / "rviz" / "drive.rviz").read_text()))
    shown = re.findall(r'"(/show/\w+)"', (package / "scripts" / "show.py").read_text())
    lidars = [ego + default.sensors[name].topic for name in ("lidar", "planar_lidar")]
    known = {*shown, *lidars, ego + default.front.image, ego + "/odometry"}
    known |= {"/carla/markers", "/camera/lane_mask", "/initialpose", "/clicked_point"}
    assert configured == known
