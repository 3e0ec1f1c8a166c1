"""Studies: which drives they describe, and one line for each mistake."""

import re
from pathlib import Path

import pytest
import yaml

from sdc_experiments.sweep.settings import nested
from sdc_experiments.sweep.study import load_study

MISTAKES = yaml.safe_load(Path(__file__).with_name("study_mistakes.yaml").read_text("utf-8"))
STUDY = """
scenarios: [town, bend.yaml]
settings: {steering_method: stanley}
factors:
  simple_controller/stanley/k: [1.0, 2.5]
  sim_options/odometry_noise/position_m: [0.0, 0.05, 0.1]
seeds: 4
"""
BEND = "route: [{straight_m: 10}, {left_deg: 20, radius_m: 30, transition_m: 4}]\n"


@pytest.fixture
def write(tmp_path):
    (tmp_path / "bend.yaml").write_text(BEND)

    def write(content):
        path = tmp_path / "study.yaml"
        path.write_text(content)
        return str(path)

    return write


def test_each_combination_is_driven_with_each_seed(write, tmp_path):
    study = load_study(write(STUDY))
    cells = study.cells()
    assert len(cells) == len({cell.key for cell in cells}) == 2 * 2 * 3 * 4
    assert {cell.scenario for cell in cells} == {"town", str(tmp_path / "bend.yaml")}
    assert [cell.seed for cell in cells[:5]] == [1, 2, 3, 4, 1]
    assert nested(cells[-1].settings, "simple_controller") == {"stanley": {"k": 2.5}}
    assert nested(cells[-1].settings, "sim_options") == {"odometry_noise": {"position_m": 0.1}}
    assert cells[-1].settings["steering_method"] == "stanley"


def test_changed_scenario_changes_the_identity(write, tmp_path):
    before = load_study(write(STUDY)).identity()
    assert load_study(write(STUDY)).identity() == before
    (tmp_path / "bend.yaml").write_text(BEND.replace("10", "11"))
    after = load_study(write(STUDY)).identity()
    assert [name for name in before if before[name] != after[name]] == ["files"]


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake["message"])
def test_mistake_is_named_in_one_line(write, mistake):
    path = write(mistake["study"])
    with pytest.raises(ValueError, match=re.escape(mistake["message"])) as error:
        load_study(path)
    assert str(error.value).startswith(path)
    assert "\n" not in str(error.value)
