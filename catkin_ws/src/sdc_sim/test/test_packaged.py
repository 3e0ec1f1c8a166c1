"""Scenarios, routes, vehicles and sensors that the workshop comes with, and their look-up."""

import os
import re
from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from sdc_common.validation import DocumentError
from sdc_sim.runner import launch_arguments
from sdc_sim.scenario.packaged import (
    find_packaged,
    find_route,
    find_scenario,
    folder_of,
    overridden,
    sensor_options,
    sim_options,
)
from sdc_sim.scenario.reader import Scenario, load_scenario
from sdc_testing.street_maps import needs_maps

SCENARIO = Scenario("/my/drive.yaml")
NOISE = "unknown parameter 'noise'; did you mean 'noise_m'?"
KNOWN = "The known ones are: bmw_320i ford_escort snider2009 tesla_model3 vw_vanagon"
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
        ({"gnss": 1}, "options: 'gnss' is a section with the parameters noise_m, period_s, got 1"),
        ({"gnss": {"noise": 1}}, f"options, section 'gnss': {NOISE}"),
    ],
)
def test_option_that_is_no_parameter_is_refused(options, message):
    with refused(message):
        overridden(PARAMETERS, options, "options")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("bmw_320", f"here: unknown vehicle 'bmw_320'; did you mean 'bmw_320i'? {KNOWN}"),
        ("xyz", f"here: unknown vehicle 'xyz'; {KNOWN}"),
        ("../sim", f"here: unknown vehicle '../sim'; {KNOWN}"),
    ],
)
def test_unknown_name_is_refused_with_the_sorted_known_ones(name, message):
    path = os.path.join(folder_of("vehicle"), "bmw_320i.yaml")
    assert find_packaged("vehicle", "bmw_320i", "here") == path
    with refused(message):
        find_packaged("vehicle", name, "here")


def test_sensors_of_a_scenario_are_the_parameters_of_their_file():
    assert sensor_options(SCENARIO) == {}
    standard = replace(SCENARIO, sensors="standard")
    with open(os.path.join(folder_of("sensors"), "standard.yaml"), encoding="utf-8") as file:
        expected = yaml.safe_load(file)
    first = sensor_options(standard)
    assert first == expected
    first["gnss"].clear()
    assert sensor_options(standard) == expected
    with pytest.raises(
        DocumentError, match="^/my/drive.yaml: unknown sensors 'standart'; did you mean 'standard'"
    ):
        sensor_options(replace(SCENARIO, sensors="standart"))


def test_given_settings_are_merged_for_a_sensor_and_replace_every_other_section():
    scenario = replace(SCENARIO, sim={"gnss": {"noise_m": 2.0, "period_s": 1.0}, "start": {"a": 1}})
    given = {"gnss": {"noise_m": 5.0}, "imu": {"period_s": 0.0}, "start": {"b": 2}}
    merged = {"gnss": {"noise_m": 5.0, "period_s": 1.0}}
    assert sim_options(scenario, given) == {**given, **merged}
    assert sim_options(scenario, {"gnss": 7})["gnss"] == 7


@pytest.mark.parametrize(
    ("route", "path"),
    [
        ("town", os.path.join(folder_of("route"), "waypoints.csv")),
        ("roads/mine.csv", "/my/roads/mine.csv"),
        ("/else/where.csv", "/else/where.csv"),
        ("~/mine.csv", os.path.expanduser("~/mine.csv")),
    ],
)
def test_route_is_a_name_or_a_path_relative_to_the_scenario(route, path):
    assert find_route(SCENARIO.path, route) == path


def test_unknown_route_is_refused():
    with refused(
        "/my/drive.yaml: unknown route 'twon'; use town, the path of a .csv file relative to this "
        "file, or a list of straights and bends"
    ):
        find_route(SCENARIO.path, "twon")


FOLDER = Path(folder_of("scenario"))
TABLE = (FOLDER / "README.md").read_text("utf-8").partition("| scenario |")[2].partition("\n\n")[0]
LISTED = dict(re.findall(r"^\| `(\w+)` \| (.*?) \|", TABLE, re.MULTILINE))


# Those on a map are skipped where nothing reads maps.
@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=needs_maps if "town_" in one else ()) for one in LISTED]
)
def test_listed_scenario_can_be_driven(name, tmp_path):
    scenario = load_scenario(find_scenario(name))
    got = launch_arguments(name, str(tmp_path / "report.json"), {})
    assert os.path.exists(got["waypoints_path"])
    assert scenario.about == LISTED[name]


def test_readme_lists_all_packaged_scenarios():
    assert {path.stem for path in FOLDER.glob("*.yaml")} == {*LISTED}
