"""A broken student package does not stop the world: the world never imports sdc_package."""

import os
import re

import pytest

# workshop/test/test_overlay.py has one case of it in every run.
pytestmark = [pytest.mark.slow(15), pytest.mark.nightly]

BROKEN = "def broken(:\n"
# ROS itself needs a manifest that can be read.
MANIFEST = """<package format="2">
  <name>sdc_package</name>
  <version>0.0.0</version>
  <description>A package that cannot be imported</description>
  <maintainer email="student@example.org">student</maintainer>
  <license>MIT</license>
</package>
"""
NODES_OF_THE_WORLD = ("sim", "referee", "record", "show")


@pytest.fixture
def broken_package(tmp_path, environment):
    """Put an sdc_package that cannot be imported first on the paths; return the environment."""
    package = tmp_path / "student" / "sdc_package"
    library = package / "src" / "sdc_package"
    messages = library / "msg"
    for folder in (library, messages, library / "steering", package / "scripts"):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "__init__.py").write_text(BROKEN)
    for module in ("odometry", "local_path", "local_planner", "waypoint_search", "pid"):
        (library / f"{module}.py").write_text(BROKEN)
    (package / "package.xml").write_text(MANIFEST)
    (package / "CMakeLists.txt").write_text("this is no CMake file(\n")
    return {
        **environment,
        "PYTHONPATH": os.pathsep.join([str(package / "src"), environment["PYTHONPATH"]]),
        "ROS_PACKAGE_PATH": os.pathsep.join([str(package.parent), environment["ROS_PACKAGE_PATH"]]),
    }


def test_package_of_this_test_is_broken(broken_package, start):
    program = start(["/usr/bin/python3", "-c", "import sdc_package.odometry"], broken_package)
    assert program.wait_for_end() != 0
    assert "SyntaxError" in program.output


@pytest.mark.parametrize("sync", ["true", "false"])
def test_world_runs_with_a_broken_student_package(broken_package, start, route, tmp_path, sync):
    """Odometry, pictures and clock arrive; in lockstep without a stack, after the timeouts."""
    (tmp_path / "world.launch").write_text(f"""
        <launch>
          <include file="$(find sdc_sim)/launch/sim.launch">
            <arg name="waypoints_path" value="{route}"/>
            <arg name="sync" value="{sync}"/>
            <arg name="sim_options"
                 value="{{start_patience_s: 1.0, patience_s: 0.1, unstamped_patience_s: 0.1}}"/>
          </include>
          <include file="$(find sdc_sim)/launch/referee.launch">
            <arg name="report" value="{tmp_path}/report/report.json"/>
            <arg name="record" value="true"/>
            <arg name="referee_options" value="{{pictures: false}}"/>
          </include>
          <include file="$(find sdc_sim)/launch/rviz.launch">
            <arg name="window" value="false"/>
          </include>
          <node name="publish_route" pkg="sdc_sim" type="publish_route.py" output="screen">
            <param name="waypoints_path" value="{route}"/>
          </node>
        </launch>""")
    world = start(["roslaunch", str(tmp_path / "world.launch")], broken_package)
    topics = start(["/usr/bin/python3", "-c", LISTENER], broken_package)
    assert topics.wait_for_end(90.0) == 0, topics.output + world.output[-3000:]
    for node in NODES_OF_THE_WORLD:
        assert world.pid_of(f"{node}.py")
    world.interrupt()
    assert "Traceback" not in world.output
    assert "SyntaxError" not in world.output
    assert not re.search(r"process has died|has died!", world.output), world.output[-3000:]


# Two messages of each topic show that the world advances.
LISTENER = """
import time
import rosgraph, rospy
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sdc_testing import MessageListener
from sdc_common.processes import wait_until
from sensor_msgs.msg import Image

wait_until(rosgraph.is_master_online, 30.0, "the master")
rospy.init_node("listener", disable_rostime=True)
ego = "/carla/ego_vehicle"
listeners = [
    MessageListener("/clock", Clock),
    MessageListener(ego + "/odometry", Odometry),
    MessageListener(ego + "/camera/rgb/front/image_color", Image),
]
for listener in listeners:
    wait_until(lambda: len(listener.messages) > 1, 50.0, listener.topic)
"""
