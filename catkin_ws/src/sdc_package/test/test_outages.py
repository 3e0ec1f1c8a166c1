"""A drive loses its clock, its roscore, its disk or its simulator."""

import contextlib
import json
import os
import re
import signal
import subprocess

import pytest

from sdc_common.processes import wait_until

pytestmark = pytest.mark.slow(30)

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.abspath(os.path.join(HERE, "..", "..", "..", ".."))
DRIVE = os.path.join(ROOT, "drive")
# Roslaunch logs this word when it has to kill a node.
ESCALATION = "escalating"
OPTIONS = ["headless:=true", "camera:=false", "referee_options:={pictures: false}"]


def test_nodes_without_a_clock_log_what_they_wait_for_and_end_at_once(environment, start):
    nodes = "camera mission_planner local_planner simple_controller carla_relay referee show"
    launch = start(["roslaunch", os.path.join(HERE, "without_world.launch")], environment)
    launch.wait_for_output(*(f"{node}: waiting for /clock" for node in nodes.split()))
    missing = "no publisher of /carla/ego_vehicle/obstacles, /carla/ego_vehicle/odometry"
    assert missing in launch.output
    launch.interrupt()
    assert ESCALATION not in launch.output
    assert "Traceback" not in launch.output


def roscore(start, environment):
    core = start(["roscore", "-p", environment["ROS_MASTER_URI"].rsplit(":", 1)[1]], environment)
    core.wait_for_output("started core service [/rosout]")
    return core


@pytest.mark.nightly
def test_drive_continues_without_its_roscore(environment, start, route, tmp_path):
    core = roscore(start, environment)
    # The drive outlasts the next check of the master.
    options = [f"waypoints_path:={route}", "planned_speed_mps:=4", *OPTIONS]
    drive = start(["roslaunch", "sdc_package", "all.launch", *options], environment)
    drive.wait_for_output("published a route")
    wait_for_progress(drive)
    core.interrupt()
    nodes = "sim", "local_planner", "simple_controller", "referee"
    drive.wait_for_output(*(f"{node}: no roscore responds" for node in nodes))
    assert drive.wait_for_end() == 0, drive.output
    report = json.loads((tmp_path / "report" / "report.json").read_text())
    assert report["status"] == "completed"
    assert report["cross_track_max_m"] < 0.5


def wait_for_progress(drive):
    def has_begun():
        percents = re.findall(r"referee: *([0-9.]+) %", drive.output)
        return any(float(percent) > 2.0 for percent in percents)

    wait_until(has_begun, 60.0, "progress of the drive")


@pytest.mark.nightly
def test_drive_whose_own_master_is_killed_ends_with_a_report(environment, start, tmp_path):
    drive = start([DRIVE, *OPTIONS], environment)
    wait_for_progress(drive)
    os.kill(drive.pid_of("rosmaster"), signal.SIGKILL)
    assert drive.wait_for_end() not in (0, None)
    assert "REQUIRED process [master] has died" in drive.output
    assert ESCALATION not in drive.output
    assert json.loads((tmp_path / "report" / "report.json").read_text())["status"] == "aborted"


@contextlib.contextmanager
def small_disk(folder):
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=32k", "workshop_test", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"no small disk can be mounted here: {done.stderr.strip()}")
    try:
        yield
    finally:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


@pytest.mark.nightly
def test_drive_completes_when_the_disk_is_full(environment, start, bend, tmp_path):
    with small_disk(tmp_path / "small"):
        options = ["headless:=true", "sync:=true", "camera:=false", f"waypoints_path:={bend}"]
        drive = start([DRIVE, *options, "report:=small/report.json"], environment)
        assert drive.wait_for_end() not in (0, None)
    assert "referee: completed: 100.0 %" in drive.output
    assert "No space left on device" in drive.output
    assert "Traceback" not in drive.output


@pytest.mark.parametrize("sync", ["true", pytest.param("false", marks=pytest.mark.nightly)])
def test_drive_without_a_mission_planner_ends_and_names_the_topic(environment, start, sync):
    stack = os.path.join(HERE, "without_mission.launch")
    options = ["headless:=true", "camera:=false", f"sync:={sync}", f"stack:={stack}"]
    drive = start([DRIVE, *options], environment)
    assert drive.wait_for_end() == 1, drive.output
    assert "referee: no node publishes /planner/mission_waypoints" in drive.output
    assert "did not start: no message on /planner/mission_waypoints\n" in drive.output
    assert "referee: waiting for /planner/mission_waypoints\n" in drive.output


@pytest.mark.nightly
def test_drive_whose_planner_crashes_at_every_start_ends_as_blocked(environment, start, tmp_path):
    (tmp_path / "stack.launch").write_text(
        """<launch>
  <arg name="waypoints_path"/> <arg name="headless"/> <arg name="camera"/>
  <include file="$(find sdc_package)/launch/mission_planner.launch"/>
  <include file="$(find sdc_package)/launch/simple_controller.launch"/>
  <node name="local_planner" pkg="sdc_package" type="local_planner.py" launch-prefix="/bin/false"
        respawn="true" respawn_delay="1"/>
</launch>
"""
    )
    options = ["headless:=true", "camera:=false", f"stack:={tmp_path}/stack.launch"]
    options += ["referee_options:={pictures: false, blocked_s: 4}"]
    drive = start([DRIVE, *options], environment)
    assert drive.wait_for_end() == 1
    assert "[local_planner-3] restarting process" in drive.output
    assert json.loads((tmp_path / "report" / "report.json").read_text())["status"] == "blocked"
