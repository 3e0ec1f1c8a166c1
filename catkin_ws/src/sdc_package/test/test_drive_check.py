"""The integration check that other teams run: it passes good software, and finds out what bad software does."""

import json
import os
import socket
import subprocess

import pytest

from sdc_sim.scenario.checked_drive import CheckedDrive

STACKS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "stacks")
WALL_LIMIT_S = 300.0
NO_PICTURES = {"referee_options": "{pictures: false}"}


@pytest.fixture
def environment(tmp_path):
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    return {
        **os.environ,
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(tmp_path / "ros"),
    }


def check(environment, folder, *arguments):
    """rostest sdc_sim drive.test, as a team's CI runs it; returns its exit status and what it said."""
    done = subprocess.run(
        [
            "rostest",
            "--results-base-dir",
            str(folder),
            "sdc_sim",
            "drive.test",
            "report:=found/report.json",
            *arguments,
        ],
        cwd=folder,
        env={**environment, "PWD": str(folder)},
        timeout=WALL_LIMIT_S,
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    )
    return done.returncode, done.stdout


def test_software_that_drives_beside_its_lane_fails_with_the_figures_and_leaves_its_report(
    environment, tmp_path
):
    stack = os.path.join(STACKS, "left_of_the_lane.launch")
    status, said = check(
        environment, tmp_path, "scenario:=lane_change", f"stack:={stack}", "max_cross_track_m:=0.5"
    )
    assert status != 0
    report = json.loads((tmp_path / "found" / "report.json").read_text())
    assert report["status"] == "completed"
    assert 0.7 < report["cross_track_max_m"] < 1.0
    assert f"cross_track_max_m is {report['cross_track_max_m']:.4g}, at most 0.5 is allowed" in said
    assert "cross_track_rms_m" in said
    assert "missed_ticks" not in said, "only what fell short is told"


def test_software_that_stops_at_the_lights_passes_and_drives_the_same_to_the_bit_again(
    environment, tmp_path
):
    status, said = check(environment, tmp_path, "scenario:=traffic_lights")
    assert status == 0, said
    again = tmp_path / "again" / "report.json"
    assert (
        CheckedDrive("traffic_lights", str(again), NO_PICTURES).run(
            WALL_LIMIT_S, environment=environment
        )
        == []
    )
    assert (tmp_path / "found" / "report.csv").read_bytes() == again.with_suffix(
        ".csv"
    ).read_bytes()


def test_software_that_is_blind_to_lights_is_found_out(environment, tmp_path):
    stack = os.path.join(STACKS, "blind_to_lights.launch")
    drive = CheckedDrive(
        "traffic_lights", str(tmp_path / "report.json"), {**NO_PICTURES, "stack": stack}
    )
    fell_short = drive.run(WALL_LIMIT_S, environment=environment)
    assert "infractions is 1, at most 0 is allowed" in fell_short
    assert json.loads((tmp_path / "report.json").read_text())["infractions"]["red_light"] == 1


def test_software_that_cannot_be_launched_is_told_with_its_last_words(environment, tmp_path):
    stack = tmp_path / "broken.launch"
    stack.write_text("<launch>\n  <include file='nowhere.launch'/>\n</launch>\n")
    drive = CheckedDrive("oval", str(tmp_path / "report.json"), {"stack": str(stack)})
    first, *_, last = drive.run(WALL_LIMIT_S, environment=environment)
    assert "left no report" in first
    assert "nowhere.launch" in last
