"""Tests of the scenario runner: launch arguments, and the check of a report."""

import os
import subprocess
import sys

import pytest
import yaml

from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.scenario.reader import load_scenario
from sdc_sim.scenario.runner import (
    PackagedFolders,
    find_scenario,
    launch_arguments,
    prepare,
)
from sdc_sim.scenario.yaml_document import DocumentError

FOLDERS = PackagedFolders.find()
SCENARIOS = sorted(
    name[: -len(".yaml")] for name in os.listdir(FOLDERS.scenarios) if name.endswith(".yaml")
)
EXPECTED = {
    "town",
    "oval",
    "figure_eight",
    "lane_change",
    "slalom",
    "wet_road",
    "recorded_noisy",
    "stopped_car",
    "crossing_pedestrian",
    "slow_leader",
    "late_start",
    "night",
    "student_loops",
    "student_nodes",
    "traffic_lights",
}


def write(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    return str(path)


def arguments(tmp_path, text, **given):
    return launch_arguments(load_scenario(write(tmp_path, text)), FOLDERS, "/generated.csv", given)


@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_packaged_scenario_can_be_driven_and_is_listed_in_the_readme(name, tmp_path):
    scenario = load_scenario(find_scenario(name, FOLDERS))
    got = prepare(scenario, str(tmp_path / "report.json"), {}, FOLDERS)
    assert os.path.exists(got["waypoints_path"])
    with open(os.path.join(FOLDERS.scenarios, "README.md"), encoding="utf-8") as file:
        assert f"| `{name}` | {scenario.about} |" in file.read()


def test_all_packaged_scenarios_are_expected():
    assert set(SCENARIOS) == EXPECTED


def test_each_key_of_a_scenario_reaches_its_argument(tmp_path):
    got = arguments(
        tmp_path,
        "route: town\nvehicle: bmw_320i\nstack: student_nodes\nfriction: 0.5\nstart: {left_m: 1}",
    )
    assert got["obstacles_path"] == str(tmp_path / "mine.yaml")
    assert got["waypoints_path"] == os.path.join(FOLDERS.routes, "waypoints.csv")
    assert got["stack"] == os.path.join(FOLDERS.stacks, "student_nodes.launch")
    assert yaml.safe_load(got["sim_options"]) == {
        "friction": 0.5,
        "start": {"left_m": 1.0},
        "vehicle": "bmw_320i",
    }


def test_given_arguments_override_and_options_are_merged(tmp_path):
    got = arguments(
        tmp_path,
        "route: town\nfriction: 0.5\nseed: 3",
        waypoints_path="my.csv",
        rviz="true",
        sim_options="{friction: 0.9}",
    )
    assert (got["waypoints_path"], got["rviz"]) == ("my.csv", "true")
    assert yaml.safe_load(got["sim_options"]) == {"friction": 0.9, "seed": 3}


def test_sensors_of_a_scenario_reach_their_argument_and_single_settings_are_merged(tmp_path):
    text = "sensors: standard\ntruth: false\ngnss: {noise_m: 2, outages: [{from_s: 1, to_s: 2}]}"
    got = arguments(tmp_path, text, sim_options="{gnss: {noise_m: 5}, imu: {period_s: 0}}")
    assert got["sensors"] == "standard"
    assert yaml.safe_load(got["sim_options"]) == {
        "truth": False,
        "gnss": {"noise_m": 5, "outages": [{"from_s": 1.0, "to_s": 2.0}]},
        "imu": {"period_s": 0},
    }


def test_route_file_is_relative_to_the_scenario(tmp_path):
    assert arguments(tmp_path, "route: roads/mine.csv")["waypoints_path"] == str(
        tmp_path / "roads" / "mine.csv"
    )
    assert arguments(tmp_path, "route: /else/where.csv")["waypoints_path"] == "/else/where.csv"


def test_generated_route_is_written_only_next_to_the_report(tmp_path):
    path = write(tmp_path, "route: [straight_m: 30]")
    got = prepare(load_scenario(path), str(tmp_path / "out" / "report.json"), {}, FOLDERS)
    assert got["waypoints_path"] == str(tmp_path / "out" / "report.route.csv")
    assert load_waypoints(got["waypoints_path"])[-1] == pytest.approx((30.0, 0.0))
    assert sorted(os.listdir(tmp_path)) == ["mine.yaml", "out"]


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("route: twon", ["mine.yaml", "'twon'", "town"]),
        ("vehicle: tesla_model4", ["did you mean 'tesla_model3'", "bmw_320i"]),
        ("sensors: standart", ["did you mean 'standard'"]),
        ("stack: student_node", ["did you mean 'student_nodes'"]),
    ],
)
def test_unknown_names_are_refused(tmp_path, text, parts):
    with pytest.raises(DocumentError) as refusal:
        arguments(tmp_path, text)
    assert [part for part in parts if part not in str(refusal.value)] == []


def command(*words):
    return subprocess.run(
        [sys.executable, "-m", "sdc_sim.scenario.runner", *words],
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("route: nowhere.csv", ["nowhere.csv"]),
        ("obstacles: []", ["'frame' is missing"]),
        (
            "route: [straight_m: 30]\nlights:\n  - {stop_line_m: 40, phases: [red: 1]}",
            ["line 3", "40 m along"],
        ),
        ("route: [straight_m: 30]\nstart: {along_m: 31}", ["31 m along"]),
    ],
)
def test_error_of_a_scenario_that_cannot_be_driven_is_one_line(tmp_path, text, parts):
    done = command("arguments", write(tmp_path, text), str(tmp_path / "report.json"))
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1
    assert [part for part in parts if part not in done.stderr] == []


@pytest.mark.slow(3)
def test_check_prints_violations(tmp_path):
    path, report = (
        write(tmp_path, "limits: {at_most: {cross_track_max_m: 0.5}}"),
        str(tmp_path / "report.json"),
    )
    (tmp_path / "report.csv").write_text("s_m,speed_mps\n")
    for error, status, line in (
        (0.4, 0, "all limits are met"),
        (0.6, 1, "cross_track_max_m is 0.6, at most 0.5 is allowed"),
    ):
        (tmp_path / "report.json").write_text(
            f'{{"status": "completed", "cross_track_max_m": {error}}}'
        )
        done = command("check", path, report)
        assert (done.returncode, line in done.stdout) == (status, True)
