"""What a drive depends on goes away: the clock, the roscore, the disk. Real processes under a master of their own."""

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import time

import pytest

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.abspath(os.path.join(HERE, "..", "..", "..", ".."))
DRIVE = os.path.join(ROOT, "drive")
# These words stand in a log when roslaunch had to end a node by force.
BY_FORCE = "escalating"


def test_without_a_clock_every_node_says_what_it_waits_for_and_ctrl_c_ends_them(environment, start):
    nodes = (
        "camera",
        "mission_planner",
        "local_planner",
        "simple_controller",
        "carla_relay",
        "referee",
        "show",
    )
    launch = start(["roslaunch", os.path.join(HERE, "without_world.launch")], environment)
    launch.wait_to_say(*(f"{node}: waiting for /clock" for node in nodes))
    assert "local_planner: waiting for /clock" in launch.said
    assert (
        "nobody publishes /carla/ego_vehicle/obstacles, /carla/ego_vehicle/odometry" in launch.said
    )
    launch.interrupt()
    assert BY_FORCE not in launch.said
    assert "Traceback" not in launch.said


def roscore(start, environment):
    core = start(["roscore", "-p", environment["ROS_MASTER_URI"].rsplit(":", 1)[1]], environment)
    core.wait_to_say("started core service [/rosout]")
    return core


def test_a_drive_goes_on_without_its_roscore_and_registers_with_the_next(
    environment, start, route, tmp_path
):
    core = roscore(start, environment)
    drive = start(
        [
            "roslaunch",
            "sdc_package",
            "all.launch",
            "headless:=true",
            "camera:=false",
            f"waypoints_path:={route}",
        ],
        environment,
    )
    drive.wait_to_say("published a route")
    wait_for_progress(drive)
    core.interrupt()
    drive.wait_to_say(
        *(
            f"{node}: no roscore answers"
            for node in ("sim", "local_planner", "simple_controller", "referee")
        )
    )
    roscore(start, environment)
    drive.wait_to_say(
        *(
            f"{node}: the roscore was started anew"
            for node in ("sim", "mission_planner", "local_planner", "simple_controller", "referee")
        )
    )
    os.kill(drive.process_of("local_planner"), signal.SIGKILL)
    assert drive.wait_for_end() == 0, drive.said
    assert "local_planner: was killed" in drive.said
    report = json.loads((tmp_path / "report" / "report.json").read_text())
    assert report["status"] == "completed"
    assert report["cross_track_max_m"] < 0.5


def wait_for_progress(drive):
    limit = time.monotonic() + 60.0
    while not any(
        float(percent) > 2.0 for percent in re.findall(r"referee: *([0-9.]+) %", drive.said)
    ):
        assert time.monotonic() < limit, drive.said
        time.sleep(0.1)


def test_a_drive_whose_own_master_is_killed_ends_in_order(environment, start, tmp_path):
    drive = start([DRIVE, "headless:=true", "camera:=false"], environment)
    wait_for_progress(drive)
    os.kill(drive.process_of("rosmaster"), signal.SIGKILL)
    assert drive.wait_for_end() not in (0, None)
    assert "REQUIRED process [master] has died" in drive.said
    # The referee draws its pages at the end, which on a busy machine takes longer than roslaunch waits.
    assert [
        line for line in drive.said.splitlines() if BY_FORCE in line and "referee" not in line
    ] == []
    assert json.loads((tmp_path / "report" / "report.json").read_text())["status"] == "aborted"


@contextlib.contextmanager
def small_disk(folder):
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=64k", "workshop_test", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"no small disk can be mounted here: {done.stderr.strip()}")
    try:
        yield
    finally:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


def test_a_full_disk_costs_the_report_and_not_the_drive(environment, start, route, tmp_path):
    with small_disk(tmp_path / "small"):
        drive = start(
            [
                DRIVE,
                "headless:=true",
                "sync:=true",
                "camera:=false",
                f"waypoints_path:={route}",
                "report:=small/report.json",
            ],
            environment,
        )
        assert drive.wait_for_end() not in (0, None)
    assert "referee: completed: 100.0 %" in drive.said
    assert "No space left on device" in drive.said
    assert "Traceback" not in drive.said


def test_a_report_folder_that_goes_away_costs_the_report_and_not_the_drive(
    environment, start, route, tmp_path
):
    drive = start(
        [DRIVE, "headless:=true", "sync:=true", "camera:=false", f"waypoints_path:={route}"],
        environment,
    )
    limit = time.monotonic() + 120.0
    journal = tmp_path / "report" / "report.journal"
    while not (
        journal.exists() and b'"odometry"' in journal.read_bytes()
    ):  # the drive is on, the old report's files are looked after
        assert time.monotonic() < limit, drive.said
        time.sleep(0.01)
    shutil.rmtree(tmp_path / "report")
    (tmp_path / "report").write_text("no folder")
    assert drive.wait_for_end() not in (0, None)
    assert "referee: completed: 100.0 %" in drive.said
    assert f"{tmp_path}/report" in drive.said
    assert "Not a directory" in drive.said or "File exists" in drive.said
    assert "Traceback" not in drive.said


def test_a_world_that_is_killed_in_lockstep_leaves_no_trace_of_it(
    environment, other_environment, start, route, tmp_path
):
    """The drive goes on at the very tick: the trace is that of a drive without the kill, bit for bit."""
    command = [
        DRIVE,
        "headless:=true",
        "sync:=true",
        "camera:=false",
        f"waypoints_path:={route}",
        "referee_options:={pictures: false}",
    ]
    for name in ("calm", "killed"):
        (tmp_path / name).mkdir()
    calm = start(command, environment, tmp_path / "calm")
    killed = start(command, other_environment, tmp_path / "killed")
    journal = tmp_path / "killed" / "report" / "report.journal"
    limit = time.monotonic() + 120.0
    while not (journal.exists() and journal.stat().st_size > 20_000):
        assert time.monotonic() < limit, killed.said
        time.sleep(0.002)
    os.kill(killed.process_of("sim.py"), signal.SIGKILL)
    assert [calm.wait_for_end(), killed.wait_for_end()] == [0, 0], killed.said[-3000:]
    assert "sim: was killed; the world goes on at tick" in killed.said
    traces = [
        (tmp_path / name / "report" / "report.csv").read_bytes() for name in ("calm", "killed")
    ]
    assert traces[0] == traces[1]
