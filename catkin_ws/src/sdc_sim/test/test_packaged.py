"""Tests of the look-up of scenarios, routes, vehicles and configurations."""

import os
import re
from dataclasses import replace

import pytest
import yaml

from sdc_sim.scenario.packaged import (
    PackagedFolders,
    find_packaged,
    find_route,
    overridden,
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


def test_given_settings_are_merged_for_a_sensor_and_replace_every_other_section():
    scenario = replace(SCENARIO, sim={"gnss": {"noise_m": 2.0, "period_s": 1.0}, "start": {"a": 1}})
    given = {"gnss": {"noise_m": 5.0}, "imu": {"period_s": 0.0}, "start": {"b": 2}}
    assert sim_options(scenario, FOLDERS, given) == {
        "gnss": {"noise_m": 5.0, "period_s": 1.0},
        "imu": {"period_s": 0.0},
        "start": {"b": 2},
    }
    assert sim_options(scenario, FOLDERS, {"gnss": 7})["gnss"] == 7


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
