"""The nodes of the lab receive nothing that a car on the road does not have."""

import re
import subprocess

import pytest

NODES = [
    "dead_reckoning",
    "lane_detector",
    "lane_follower",
    "lane_stages",
    "obstacle_detector",
    "steering_network",
    "traffic_follower",
    "traffic_light_detector",
]
# Of the three detectors.
SHARED = "src/sdc_perception/picture_detector.py"
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


@pytest.mark.parametrize("file", [*(f"scripts/{node}.py" for node in NODES), SHARED])
def test_nodes_use_no_topic_of_route_or_truth(rospkg_path, file):
    code = rospkg_path("sdc_perception", *file.split("/")).read_text(encoding="utf-8")
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
def test_only_nodes_of_the_lab_and_the_controller_are_started(rospkg_path, perception, own):
    launch = rospkg_path("sdc_perception", "launch", "perception.launch")
    command = ["roslaunch", "--nodes", str(launch), f"perception:={perception}"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    both = ["dead_reckoning", "lane_detector", "publish_route", "simple_controller"]
    assert sorted(done.stdout.split()) == sorted(f"/{name}" for name in [*both, *own])


@pytest.mark.slow(3)
def test_objects_in_the_picture_are_those_of_the_planner_on_a_map(rospkg_path):
    launch = str(rospkg_path("sdc_package", "launch", "all.launch"))
    options = ["map:=town", "goal:=[]", "perception:=objects", "headless:=true"]
    command = ["roslaunch", "--nodes", launch, *options]
    nodes = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    assert {"/obstacle_detector", "/global_planner", "/local_planner"} <= {*nodes}
    assert not {"/lane_detector", "/traffic_light_detector", "/dead_reckoning"} & {*nodes}
    command = ["roslaunch", "--args=/local_planner", launch, *options]
    line = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "/carla/ego_vehicle/obstacles:=/perception/obstacles" in line


def test_readme_lists_topics_and_parameters(rospkg_path):
    readme = rospkg_path("sdc_perception", "README.md").read_text(encoding="utf-8")
    for topic in ALLOWED:
        assert f"`{topic.replace('/carla/ego_vehicle', 'ego')}`" in readme, topic
    for path in rospkg_path("sdc_perception", "config").iterdir():
        for name in re.findall(r"^([a-z_0-9]+):", path.read_text(encoding="utf-8"), re.MULTILINE):
            assert f"`{name}`" in readme, name
