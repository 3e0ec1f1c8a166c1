"""The scenarios that the workshop comes with."""

import os
import re
from pathlib import Path

import pytest

from sdc_sim.runner import launch_arguments
from sdc_sim.scenario.packaged import find_scenario, folder_of
from sdc_sim.scenario.reader import load_scenario
from sdc_testing.street_maps import needs_maps

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
