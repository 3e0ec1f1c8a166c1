"""The scenarios that the workshop comes with."""

import os

import pytest

from sdc_sim.runner import prepare
from sdc_sim.scenario.packaged import find_scenario, folder_of
from sdc_sim.scenario.reader import load_scenario
from sdc_testing.street_maps import needs_maps

SCENARIOS = sorted(
    name[: -len(".yaml")] for name in os.listdir(folder_of("scenario")) if name.endswith(".yaml")
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
    "traffic_lights",
    "town_motorway",
    "town_right_before_left",
    "town_roundabout",
    "town_lights",
    "town_car_park",
    "town_country_road",
    "town_slow_van",
    "town_traffic",
    "town_pedestrians",
    "town_motorway_traffic",
}


def with_maps(names):
    """Return parameters: those of scenarios on a map are skipped where nothing reads maps."""
    return [pytest.param(one, marks=needs_maps if "town_" in one else ()) for one in sorted(names)]


@pytest.mark.parametrize("name", with_maps(EXPECTED))
def test_packaged_scenario_can_be_driven_and_is_listed_in_the_readme(name, tmp_path):
    scenario = load_scenario(find_scenario(name))
    got = prepare(scenario, str(tmp_path / "report.json"), {})
    assert os.path.exists(got["waypoints_path"])
    with open(os.path.join(folder_of("scenario"), "README.md"), encoding="utf-8") as file:
        assert f"| `{name}` | {scenario.about} |" in file.read()


def test_all_packaged_scenarios_are_expected():
    assert set(SCENARIOS) == EXPECTED
