"""The stack of another workspace, whose package has the name of ours, drives in that workspace."""

import json
import math
import os
from pathlib import Path

import pytest
import rosbag

from sdc_testing.program import run

pytestmark = pytest.mark.slow(25)

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", "..", ".."))
DRIVE = os.path.join(ROOT, "drive")
SHAPES = Path(__file__).parent.glob("*_shape/*.py")
DEPENDENCIES = ("message_generation", "message_runtime", "nav_msgs", "rospy", "std_msgs", "tf")
PACKAGE = {
    "package.xml": """<package format="2">
        <name>sdc_package</name> <version>0.0.0</version> <description>A stack</description>
        <maintainer email="student@example.org">student</maintainer> <license>MIT</license>
        <buildtool_depend>catkin</buildtool_depend>
        """
    + "\n".join(f"<depend>{name}</depend>" for name in DEPENDENCIES)
    + "</package>",
    "CMakeLists.txt": """
        cmake_minimum_required(VERSION 3.5)
        project(sdc_package)
        find_package(catkin REQUIRED COMPONENTS message_generation std_msgs)
        add_message_files(DIRECTORY msg)
        generate_messages(DEPENDENCIES std_msgs)
        catkin_package()""",
    # Their waypoints have a field that ours do not have, and it is not the last one.
    "msg/Waypoint.msg": "float32 x\nfloat32 y\nfloat32 yaw\nfloat32 v\n",
    "msg/BaseWaypoint.msg": "float32 x\nfloat32 y\n",
    "msg/LocalPath.msg": "Waypoint[] waypoints\n",
    "msg/Path.msg": "BaseWaypoint[] waypoints\n",
    "msg/CarlaVehicleControl.msg": "Header header\nfloat32 throttle\nfloat32 steer\n"
    "float32 brake\nbool hand_brake\nbool reverse\n",
    "launch/nodes.launch": """<launch>
        <arg name="waypoints_path"/>
        <node name="planner" pkg="sdc_package" type="planner.py" output="screen">
          <param name="waypoints_path" value="$(arg waypoints_path)"/>
        </node>
        <node name="controller" pkg="sdc_package" type="controller.py" output="screen"/>
        </launch>""",
    "scripts/planner.py": """#!/usr/bin/env python3
import rospy
from nav_msgs.msg import Odometry
from sdc_package.msg import BaseWaypoint, LocalPath, Path, Waypoint

rospy.init_node("planner")
with open(rospy.get_param("~waypoints_path")) as file:
    points = [tuple(map(float, line.split(",")[:2])) for line in file]
points = [(x, -y) for x, y in points]
mission = rospy.Publisher("/planner/mission_waypoints", Path, queue_size=1, latch=True)
local = rospy.Publisher("/planner/local_waypoints", LocalPath, queue_size=1)
mission.publish(Path([BaseWaypoint(x, y) for x, y in points]))

def plan(odometry):
    car = odometry.pose.pose.position
    nearest = min(range(len(points)), key=lambda i: abs(points[i][0] - car.x))
    speed = 5.0 if nearest < len(points) - 8 else 0.0
    local.publish(LocalPath([Waypoint(x, y, 0.5, speed) for x, y in points[nearest:nearest + 10]]))

rospy.Subscriber("/carla/ego_vehicle/odometry", Odometry, plan, queue_size=1)
rospy.spin()
""",
    "scripts/controller.py": """#!/usr/bin/env python3
import math
import rospy
import tf
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl, LocalPath

rospy.init_node("controller")
publisher = rospy.Publisher(
    "/carla/ego_vehicle/vehicle_control_cmd", CarlaVehicleControl, queue_size=1)
newest = []

def on_path(message):
    if newest:
        control(message.waypoints, newest[-1])

def control(path, odometry):
    pose, speed = odometry.pose.pose, odometry.twist.twist.linear.x
    turn = pose.orientation
    yaw = tf.transformations.euler_from_quaternion((turn.x, turn.y, turn.z, turn.w))[2]
    command = CarlaVehicleControl()
    if path:
        ahead = path[-1]
        heading = math.atan2(ahead.y - pose.position.y, ahead.x - pose.position.x) - yaw
        command.steer = -max(-1.0, min(1.0, math.remainder(heading, 2.0 * math.pi)))
        command.throttle = 0.5 if speed < path[0].v else 0.0
        command.brake = 0.3 if path[0].v == 0.0 else 0.0
    publisher.publish(command)

rospy.Subscriber("/planner/local_waypoints", LocalPath, on_path, queue_size=1)
rospy.Subscriber("/carla/ego_vehicle/odometry", Odometry, newest.append, queue_size=1)
rospy.spin()
""",
}


@pytest.fixture(scope="module")
def workspace(tmp_path_factory):
    """Build their workspace on top of ours; its sdc_package hides ours."""
    folder = tmp_path_factory.mktemp("their") / "ws"
    shapes = {f"scripts/{path.name}": path.read_text() for path in SHAPES}
    for name, text in {**PACKAGE, **shapes}.items():
        path = folder / "src" / "sdc_package" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)
    python_only = {**os.environ, "ROS_LANG_DISABLE": "gencpp:genlisp:geneus:gennodejs"}
    build = "catkin_make", "-DPYTHON_EXECUTABLE=/usr/bin/python3"
    done = run(*build, folder=folder, environment=python_only)
    assert done.returncode == 0, done.stdout
    return folder


@pytest.fixture
def road(tmp_path):
    path = tmp_path / "straight.csv"
    path.write_text("".join(f"{x},{0.01 * x}\n" for x in range(61)))
    return path


def report_of(folder):
    with open(folder / "report" / "report.json", encoding="utf-8") as file:
        return json.load(file)


def test_list_of_nodes_drives_and_its_path_is_read_and_recorded(
    workspace, road, environment, tmp_path
):
    arguments = [
        f"workspace:={workspace}",
        "stack:=sdc_package/planner.py sdc_package/controller.py",
        f"waypoints_path:={road}",
    ]
    options = ["headless:=true", "sync:=true", "camera:=false", "record:=true"]
    options += ["sim_options:={unstamped_patience_s: 0.01}", "referee_options:={pictures: false}"]
    done = run(DRIVE, *arguments, *options, folder=tmp_path, environment=environment)
    assert done.returncode == 0, done.stdout
    for part in ("Traceback", "refused a message", "md5sum"):
        assert part not in done.stdout
    assert report_of(tmp_path)["status"] == "completed"
    with rosbag.Bag(str(tmp_path / "report" / "report.bag")) as bag:
        _, path, _ = next(bag.read_messages("/planner/local_waypoints"))
    assert (path.waypoints[0].yaw, path.waypoints[0].v) == (0.5, 5.0)


@pytest.mark.nightly
def test_nodes_of_the_original_workshop_drive_by_the_commands_of_the_page(
    workspace, route, environment, tmp_path
):
    with open(route, encoding="utf-8") as file:
        published = "".join(line.rstrip() + ",0\r\r\n" for line in file if line.strip())
    (tmp_path / "published.csv").write_bytes(published.encode())
    with open(os.path.join(ROOT, "docs", "integration.md"), encoding="utf-8") as page:
        section = page.read().split("### The solution of the original workshop")[1]
    clean = next(line for line in section.splitlines() if "tr -d" in line)
    drive = section[section.index("./drive") :].split("\n\n")[0]
    commands = f"{clean}\n{drive} headless:=true camera:=false"
    commands = commands.replace("./drive", DRIVE)
    commands = commands.replace("PATH_OF_THE_SOLUTION/waypoints.csv", "published.csv")
    (tmp_path / "original").symlink_to(workspace)
    home = {**environment, "HOME": str(tmp_path)}
    done = run("bash", "-ec", commands, folder=tmp_path, environment=home)
    assert done.returncode == 0, done.stdout
    report = report_of(tmp_path)
    assert report["status"] == "completed"
    assert report["cross_track_max_m"] < 5.0


def test_follower_of_autoware_minis_shape_drives_by_ackermann_targets(
    workspace, environment, tmp_path
):
    bends = tmp_path / "bends.csv"
    bends.write_text("".join(f"{x},{8.0 * math.sin(x / 25.0):.4f}\n" for x in range(151)))
    arguments = [
        f"workspace:={workspace}",
        "stack:=sdc_package/mission_planner.py sdc_package/follower.py",
        f"waypoints_path:={bends}",
    ]
    options = ["headless:=true", "sync:=true", "camera:=false"]
    options += ["referee_options:={pictures: false}"]
    done = run(DRIVE, *arguments, *options, folder=tmp_path, environment=environment)
    assert done.returncode == 0, done.stdout
    report = report_of(tmp_path)
    assert report["status"] == "completed"
    assert report["ticks_by_order"] > 0, "on a busy machine, some answers come after the timeout"
    assert report["cross_track_max_m"] < 0.5


@pytest.mark.nightly
def test_check_in_an_overlay_drives_its_launch_file_in_our_world(
    workspace, road, environment, tmp_path
):
    check = ["rostest", "--results-base-dir", str(tmp_path), "sdc_sim", "drive.test"]
    check += [f"waypoints_path:={road}", "camera:=false"]
    overlay = ["bash", "-c", 'uri=$ROS_MASTER_URI; source "$0" && ROS_MASTER_URI=$uri "$@"']
    overlay.append(str(workspace / "devel" / "setup.bash"))
    stack = [f"workspace:={workspace}", "stack:=sdc_package/nodes.launch"]
    done = run(*overlay, *check, *stack, folder=tmp_path, environment=environment)
    assert done.returncode == 0, done.stdout
    assert report_of(tmp_path)["status"] == "completed"

    done = run(*overlay, *check, folder=tmp_path, environment=environment)
    assert done.returncode != 0
    assert "add workspace:=" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["workspace:={}"], ["{}", "has no 'stack.launch'", "stack:=PACKAGE/FILE.launch"]),
        (["stack:={}/src/sdc_package/launch/nodes.launch"], ["add workspace:={}"]),
    ],
)
def test_stack_that_cannot_drive_ends_with_one_line(
    workspace, environment, tmp_path, arguments, parts
):
    given = [argument.format(workspace) for argument in arguments]
    done = run(DRIVE, "headless:=true", *given, folder=tmp_path, environment=environment)
    assert done.returncode != 0
    assert len(done.stdout.splitlines()) == 1, done.stdout
    assert [part for part in parts if part.format(workspace) not in done.stdout] == []
