"""Scenarios that are driven on what the detectors find in the picture."""

import os

import pytest

from sdc_common.ros.master_port import free_master_port
from sdc_experiments.perception_drive import SCENARIOS, drive_on_detections
from sdc_experiments.perception_frames import FrameScore, measure
from sdc_sim.report.writer import write_report
from sdc_sim.scenario.runner import CheckedDrive

TIMEOUT_S = 300.0


def undisturbed(scenario, weather="day"):
    drive = drive_on_detections(scenario, weather)
    assert drive.problems == []


@pytest.mark.slow(14)
def test_car_waits_for_a_pedestrian_in_the_picture():
    undisturbed("crossing_pedestrian")


@pytest.mark.nightly
@pytest.mark.parametrize("weather", ["day", "dusk"])
@pytest.mark.parametrize("scenario", ["traffic_lights", "stopped_car", "slow_leader"])
def test_scenario_is_driven_on_detections(scenario, weather):
    undisturbed(scenario, weather)


@pytest.mark.nightly
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_drive_of_nodes_is_that_in_one_process(scenario, tmp_path):
    arguments = {"perception": "all", "camera": "true", "referee_options": "{pictures: false}"}
    drive = CheckedDrive(scenario, str(tmp_path / "nodes.json"), arguments)
    environment = {
        **os.environ,
        "ROS_MASTER_URI": f"http://127.0.0.1:{free_master_port()}",
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(tmp_path / "ros"),
    }
    assert drive.run(TIMEOUT_S, environment=environment) == []
    write_report(str(tmp_path / "process.json"), drive_on_detections(scenario).result)
    assert (tmp_path / "process.csv").read_text() == (tmp_path / "nodes.csv").read_text()


@pytest.mark.slow(4)
@pytest.mark.parametrize("weather", ["day", "dusk"])
def test_lights_and_bodies_of_random_pictures_are_right(weather):
    score = measure(weather, 40, 2901)
    assert score.lights >= 15
    assert score.right_frames >= 39
    assert score.bodies >= 20
    assert score.found_bodies >= 0.97 * score.bodies
    assert sum(abs(error) < 0.1 for error in score.body_errors) >= 0.97 * score.found_bodies
    assert score.false_bodies <= 1


def test_table_has_the_sum_of_both_weathers():
    day = FrameScore(
        2, 2, 3, 3, 0, 4, 3, 1, [0.01, 0.02, 0.03], [0.0, 0.0, 0.2], [(1e-3, 2e-3)] * 2
    )
    dusk = FrameScore(2, 1, 1, 0, 1, 0, 0, 0, [], [], [(3e-3, 2e-3)] * 2)
    assert (day + dusk).row("all") == (
        "| all | 4 | 75.00 % | 3 of 4, 1 | 2.0 %, 2.9 % | 3 of 4, 1 | 0.0 %, 18.0 % | 66.67 % "
        "| 2.0 + 2.0 ms |"
    )
