"""Tests of the scenario runner: launch arguments, and the check of a report."""

import os
import re
import sys

import pytest
import yaml

from sdc_common.routes.waypoint_file import load_waypoints
from sdc_common.validation import DocumentError
from sdc_sim.catkin_workspace import WorkspaceError
from sdc_sim.runner import CheckedDrive, launch_arguments, main
from sdc_sim.scenario.packaged import folder_of

SHORT = "route: [straight_m: 30]\n"


def write(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    return str(path)


def arguments(tmp_path, text, **given):
    return launch_arguments(write(tmp_path, text), str(tmp_path / "report.json"), given)


def test_each_key_of_a_scenario_reaches_its_argument(tmp_path):
    text = "route: town\nvehicle: bmw_320i\nfriction: 0.5\nstart: {left_m: 1}"
    got = arguments(tmp_path, text)
    assert got["obstacles_path"] == str(tmp_path / "mine.yaml")
    assert got["waypoints_path"] == os.path.join(folder_of("route"), "waypoints.csv")
    options = {"friction": 0.5, "start": {"left_m": 1.0}, "vehicle": "bmw_320i"}
    assert yaml.safe_load(got["sim_options"]) == options


def test_given_arguments_override_and_options_are_merged(tmp_path):
    mine = str(tmp_path / "my.csv")
    (tmp_path / "my.csv").write_text("0,0\n50,0\n")
    given = {"waypoints_path": mine, "rviz": "true", "sim_options": "{friction: 0.9}"}
    got = arguments(tmp_path, "route: town\nfriction: 0.5\nseed: 3", **given)
    assert (got["waypoints_path"], got["rviz"]) == (mine, "true")
    assert yaml.safe_load(got["sim_options"]) == {"friction": 0.9, "seed": 3}


def test_generated_route_is_written_only_next_to_the_report(tmp_path):
    path = write(tmp_path, "route: [straight_m: 30]")
    got = launch_arguments(path, str(tmp_path / "out" / "report.json"), {})
    assert got["waypoints_path"] == str(tmp_path / "out" / "report.route.csv")
    assert load_waypoints(got["waypoints_path"])[-1] == pytest.approx((30.0, 0.0))
    assert sorted(os.listdir(tmp_path)) == ["mine.yaml", "out"]


@pytest.fixture
def command(monkeypatch, capsys):
    """Return a function that runs the command line: exit status, output and errors."""

    def run(*words):
        monkeypatch.setattr(sys, "argv", ["runner", *words])
        return (main(), *capsys.readouterr())

    return run


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("route: nowhere.csv", ["nowhere.csv"]),
        ("obstacles: []", ["'frame' is missing"]),
        (f"{SHORT}lights:\n  - {{stop_line_m: 40, phases: [red: 1]}}", ["line 3", "40 m along"]),
        (f"{SHORT}start: {{along_m: 31}}", ["31 m along"]),
    ],
)
def test_error_of_a_scenario_that_cannot_be_driven_is_one_line(command, tmp_path, text, parts):
    status, output, errors = command(
        "arguments", write(tmp_path, text), str(tmp_path / "report.json")
    )
    assert (status, output, len(errors.splitlines())) == (1, "", 1)
    assert [part for part in parts if part not in errors] == []


def test_arguments_are_printed_one_per_line_and_options_last(command, tmp_path):
    path = write(tmp_path, "route: town\nseed: 3")
    given = ["--screen", "rviz:=true", "sim_options:={vehicle: a:=b}"]
    status, output, errors = command("arguments", path, str(tmp_path / "report.json"), *given)
    assert (status, errors) == (0, "")
    paths = [f"obstacles_path:={path}", f"waypoints_path:={folder_of('route')}/waypoints.csv"]
    options = ["rviz:=true", "sim_options:={seed: 3, vehicle: 'a:=b'}", "--screen"]
    assert output.splitlines() == paths + options


@pytest.mark.parametrize("options", ["7", "{friction", "[1]"])
def test_options_that_are_no_mapping_are_refused(tmp_path, options):
    with pytest.raises(DocumentError, match=f"^sim_options:={re.escape(options)}: must be a map"):
        arguments(tmp_path, "route: town", sim_options=options)


def test_check_prints_violations(command, tmp_path):
    path, report = write(tmp_path, "limits: {at_most: {cross_track_max_m: 0.5}}"), "report.json"
    (tmp_path / "report.csv").write_text("s_m,speed_mps\n")
    violation = f"{tmp_path}/report.json: cross_track_max_m is 0.6, at most 0.5 is allowed"
    for error, expected in (
        (0.4, (0, [f"scenario {path}: all limits are met"])),
        (0.6, (1, [violation, f"scenario {path}: limits violated"])),
    ):
        (tmp_path / report).write_text(f'{{"status": "completed", "cross_track_max_m": {error}}}')
        status, output, errors = command("check", path, str(tmp_path / report))
        assert (status, output.splitlines(), errors) == (*expected, "")


def test_drive_gets_the_arguments_of_its_scenario(tmp_path):
    text = "route: town\ncamera: false\nsync: false\nlimits: {at_most: {missed_ticks: 3}}"
    path, report = write(tmp_path, text), str(tmp_path / "found" / "report.json")
    drive = CheckedDrive(path, report, {"rviz": "true", "headless": "false"})
    expected = {"sync": "false", "camera": "false", "rviz": "true", "headless": "true"}
    expected.update(obstacles_path=path, sim_options="{}", report=report)
    expected["waypoints_path"] = os.path.join(folder_of("route"), "waypoints.csv")
    assert drive.arguments == expected
    assert (drive.limits["at_most"], drive.environment) == ({"missed_ticks": 3.0}, os.environ)
    assert drive.log_path == str(tmp_path / "found" / "report.log")
    assert os.listdir(tmp_path / "found") == []


def test_package_that_hides_the_world_is_refused(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    CheckedDrive("", str(tmp_path / "report.json"), {})  # roslaunch names the missing package.
    folder = tmp_path / "sdc_package"
    (folder / "launch").mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>sdc_package</name></package>")
    refusal = (
        f"{folder}: this sdc_package hides the one whose all.launch starts the world; "
        "add workspace:=FOLDER, the workspace that it belongs to"
    )
    for text in (None, "<launch/>"):
        if text:
            (folder / "launch" / "all.launch").write_text(text)
        with pytest.raises(WorkspaceError, match=f"^{re.escape(refusal)}$"):
            CheckedDrive("", str(tmp_path / "report.json"), {})
    (folder / "launch" / "all.launch").write_text("<launch><!-- sdc_sim --></launch>")
    CheckedDrive("", str(tmp_path / "report.json"), {})
