"""The nodes of the lab receive nothing that a car on the road does not have."""

import re
import subprocess
from pathlib import Path

import pytest

LAB = Path(__file__).resolve().parents[1]
# The last one is what the three detectors share.
FILES = [*sorted(LAB.glob("scripts/*.py")), *LAB.glob("src/sdc_perception/picture_detector.py")]
ALLOWED = {
    "/carla/ego_vehicle/imu",
    "/carla/ego_vehicle/wheel_speeds",
    "/carla/ego_vehicle/odometry",
    "/carla/ego_vehicle/camera/rgb/front/image_color",
    "/carla/ego_vehicle/camera/rgb/front/camera_info",
    "/perception/lane",
    "/perception/lane_overlay",
    "/perception/obstacles",
    "/perception/obstacles_overlay",
    "/perception/traffic_lights",
    "/perception/traffic_lights_overlay",
    "/planner/local_waypoints",
}


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_nodes_use_no_topic_of_route_or_truth(file):
    code = file.read_text(encoding="utf-8")
    ego, camera = "/carla/ego_vehicle", "{EGO}/camera/rgb/front"
    code = code.replace(f'"{ego}"', "").replace(f'f"{camera}"', "")
    code = code.replace("{CAMERA}", camera).replace("{EGO}", ego)
    topics = set(re.findall(r'"(/[a-z_]+(?:/[a-z_]+)+)"', code))
    assert topics
    assert topics <= ALLOWED


@pytest.mark.slow(3)
@pytest.mark.parametrize(
    ("perception", "own"),
    [
        ("lane", ["lane_follower"]),
        ("all", ["obstacle_detector", "traffic_follower", "traffic_light_detector"]),
    ],
)
def test_only_nodes_of_the_lab_and_the_controller_are_started(perception, own):
    launch = LAB / "launch" / "perception.launch"
    command = ["roslaunch", "--nodes", str(launch), f"perception:={perception}"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    both = ["dead_reckoning", "lane_detector", "publish_route", "simple_controller"]
    assert sorted(done.stdout.split()) == sorted(f"/{name}" for name in [*both, *own])


@pytest.mark.slow(3)
def test_objects_in_the_picture_are_those_of_the_planner_on_a_map():
    options = ["map:=town", "goal:=[]", "perception:=objects", "headless:=true"]
    command = ["roslaunch", "--nodes", "sdc_package", "all.launch", *options]
    nodes = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    assert {"/obstacle_detector", "/global_planner", "/local_planner"} <= {*nodes}
    assert not {"/lane_detector", "/traffic_light_detector", "/dead_reckoning"} & {*nodes}
    command = ["roslaunch", "--args=/local_planner", "sdc_package", "all.launch", *options]
    line = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "/carla/ego_vehicle/obstacles:=/perception/obstacles" in line


def test_readme_lists_topics_and_parameters():
    readme = (LAB / "README.md").read_text(encoding="utf-8")
    for topic in ALLOWED:
        assert f"`{topic.replace('/carla/ego_vehicle', 'ego')}`" in readme, topic
    for path in (LAB / "config").iterdir():
        for name in re.findall(r"^([a-z_0-9]+):", path.read_text(encoding="utf-8"), re.MULTILINE):
            assert f"`{name}`" in readme, name
