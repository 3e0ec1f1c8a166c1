"""Tests of the look-up of scenarios, routes, vehicles and configurations."""

import os
import re
from dataclasses import replace

import pytest
import yaml

from sdc_common.routes.waypoint_file import parse_waypoints
from sdc_sim.scenario.packaged import (
    PackagedFolders,
    find_packaged,
    find_route,
    find_scenario,
    generated_lines,
    node_config,
    overridden,
    package_folder,
    sensor_options,
    sim_options,
)
from sdc_sim.scenario.reader import Scenario
from sdc_sim.yaml_document import DocumentError

FOLDERS = PackagedFolders.find()
SCENARIO = Scenario("/my/drive.yaml")
PARAMETERS = {"friction": 0.9, "gnss": {"noise_m": 0.0, "period_s": 0.1}}


def refused(message):
    return pytest.raises(DocumentError, match=f"^{re.escape(message)}$")


@pytest.mark.parametrize(
    ("kind", "file"),
    [
        ("scenarios", "town.yaml"),
        ("stacks", "student_nodes.launch"),
        ("vehicles", "bmw_320i.yaml"),
        ("routes", "waypoints.csv"),
        ("sensors", "standard.yaml"),
    ],
)
def test_each_folder_has_the_files_of_its_kind(kind, file):
    assert os.path.isfile(os.path.join(getattr(PackagedFolders.find(), kind), file))


def test_parameters_of_a_node_are_those_of_its_file_and_can_be_changed():
    with open(os.path.join(package_folder("sdc_sim"), "config", "sim.yaml"), encoding="utf-8") as f:
        expected = yaml.safe_load(f)
    first = node_config("sdc_sim", "sim")
    assert first == expected
    first["start"]["along_m"] = 7.0
    assert node_config("sdc_sim", "sim") == expected


def test_options_replace_parameters_and_sections_are_merged():
    found = overridden(PARAMETERS, {"gnss": {"noise_m": 2.0}}, "options")
    assert found == {"friction": 0.9, "gnss": {"noise_m": 2.0, "period_s": 0.1}}
    assert overridden(PARAMETERS, {"friction": 0.3}, "options")["friction"] == 0.3
    assert PARAMETERS == {"friction": 0.9, "gnss": {"noise_m": 0.0, "period_s": 0.1}}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"frictoin": 1}, "options: unknown parameter 'frictoin'; did you mean 'friction'?"),
        ({"xyz": 1}, "options: unknown parameter 'xyz'; remove it"),
        ({7: 1}, "options: unknown parameter '7'; remove it"),
        (
            {"gnss": 1},
            "options: 'gnss' is a section with the parameters noise_m, period_s, got 1",
        ),
        (
            {"gnss": {"noise": 1}},
            "options, section 'gnss': unknown parameter 'noise'; did you mean 'noise_m'?",
        ),
    ],
)
def test_option_that_is_no_parameter_is_refused(options, message):
    with refused(message):
        overridden(PARAMETERS, options, "options")


def test_scenario_is_found_by_name_or_path():
    assert find_scenario("town", FOLDERS) == os.path.join(FOLDERS.scenarios, "town.yaml")
    assert find_scenario("my/own.yaml", FOLDERS) == "my/own.yaml"
    with pytest.raises(
        DocumentError,
        match="^scenario:=NAME: unknown scenario 'twon'; did you mean 'town'[?] The known ones are",
    ):
        find_scenario("twon", FOLDERS)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "thre",
            "here: unknown word 'thre'; did you mean 'three'? The known ones are: one three",
        ),
        ("xyz", "here: unknown word 'xyz'; The known ones are: one three"),
        ("two.txt", "here: unknown word 'two.txt'; The known ones are: one three"),
    ],
)
def test_unknown_name_is_refused_with_the_sorted_known_ones(tmp_path, name, message):
    for file in ("three.yaml", "one.yaml", "two.txt"):
        (tmp_path / file).touch()
    assert find_packaged("word", "one", str(tmp_path), ".yaml", "here") == str(
        tmp_path / "one.yaml"
    )
    with refused(message):
        find_packaged("word", name, str(tmp_path), ".yaml", "here")


def test_sensors_of_a_scenario_are_the_parameters_of_their_file():
    assert sensor_options(SCENARIO, FOLDERS) == {}
    standard = replace(SCENARIO, sensors="standard")
    with open(os.path.join(FOLDERS.sensors, "standard.yaml"), encoding="utf-8") as file:
        expected = yaml.safe_load(file)
    first = sensor_options(standard, FOLDERS)
    assert first == expected
    first["gnss"].clear()
    assert sensor_options(standard, FOLDERS) == expected
    with pytest.raises(
        DocumentError, match="^/my/drive.yaml: unknown sensors 'standart'; did you mean 'standard'"
    ):
        sensor_options(replace(SCENARIO, sensors="standart"), FOLDERS)


def test_options_of_a_scenario_are_its_own_its_vehicle_and_the_given_ones():
    scenario = replace(SCENARIO, vehicle="bmw_320i", sim={"friction": 0.5, "seed": 3})
    expected = {"friction": 0.9, "seed": 3, "vehicle": "bmw_320i"}
    assert sim_options(scenario, FOLDERS, {"friction": 0.9}) == expected
    assert scenario.sim == {"friction": 0.5, "seed": 3}
    with pytest.raises(
        DocumentError, match="^/my/drive.yaml: unknown vehicle 'bmw'; .*known ones are: bmw_320i "
    ):
        sim_options(replace(SCENARIO, vehicle="bmw"), FOLDERS, {})


def test_given_settings_are_merged_for_a_sensor_and_replace_every_other_section():
    scenario = replace(SCENARIO, sim={"gnss": {"noise_m": 2.0, "period_s": 1.0}, "start": {"a": 1}})
    given = {"gnss": {"noise_m": 5.0}, "imu": {"period_s": 0.0}, "start": {"b": 2}}
    assert sim_options(scenario, FOLDERS, given) == {
        "gnss": {"noise_m": 5.0, "period_s": 1.0},
        "imu": {"period_s": 0.0},
        "start": {"b": 2},
    }
    assert sim_options(scenario, FOLDERS, {"gnss": 7})["gnss"] == 7


def test_generated_route_starts_at_the_origin_to_the_east_in_steps_of_one_metre():
    points = parse_waypoints("".join(generated_lines([{"straight_m": 3.0}])), "here")
    assert points.tolist() == [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]


@pytest.mark.parametrize(
    ("route", "path"),
    [
        ("town", os.path.join(FOLDERS.routes, "waypoints.csv")),
        ("roads/mine.csv", "/my/roads/mine.csv"),
        ("/else/where.csv", "/else/where.csv"),
        ("~/mine.csv", os.path.expanduser("~/mine.csv")),
    ],
)
def test_route_is_a_name_or_a_path_relative_to_the_scenario(route, path):
    assert find_route(SCENARIO.path, route, FOLDERS) == path


def test_unknown_route_is_refused():
    with refused(
        "/my/drive.yaml: unknown route 'twon'; use town, the path of a .csv file relative to this "
        "file, or a list of straights and bends"
    ):
        find_route(SCENARIO.path, "twon", FOLDERS)
