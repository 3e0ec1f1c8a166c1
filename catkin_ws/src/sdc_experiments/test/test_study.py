"""Studies: which drives they describe, and one line for each mistake."""

import re

import pytest

from sdc_experiments.sweep.settings import nested
from sdc_experiments.sweep.study import load_study

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


@pytest.mark.parametrize(
    "content, message",
    [
        ("", "the file is empty; add 'scenarios"),
        ("seeds: 3", "key 'scenarios' is missing"),
        ("scenario: [town]", "unknown key 'scenario'; did you mean 'scenarios'?"),
        ("scenarios: [twon]", "unknown scenario 'twon'; did you mean 'town'?"),
        ("scenarios: [missing.yaml]", "missing.yaml: cannot be read"),
        ("scenarios: [student_nodes]", "names a stack of nodes; add 'stack: ros'"),
        ("scenarios: town", "'scenarios' must be a list of different scenarios"),
        ("scenarios: [town]\nstack: rso", "'stack' is 'rso'; did you mean 'ros'?"),
        ("scenarios: [town]\nseeds: 0", "'seeds' must be the number of seeds"),
        ("scenarios: [town]\nseeds: [1, 1]", "'seeds' must be a list of different whole numbers"),
        ("scenarios: [town]\nmetrics: [rms]", "entry 1 of 'metrics' is 'rms'; use one of"),
        (
            "scenarios: [town]\nfactors: {planned_speed_mps: 3}",
            "must be a list of different values",
        ),
        ("scenarios: [town]\nsettings: {planed_speed_mps: 3}", "did you mean 'planned_speed_mps'?"),
        ("scenarios: [town]\nsettings: {camera: true}", "'camera' needs nodes; add 'stack: ros'"),
        ("scenarios: [town]\nsettings: {sim_options/seed: 3}", "write 'seeds: [...]'"),
        (
            "scenarios: [town]\nsettings: {simple_controller/stanley/gain: 3}",
            "simple_controller, section 'stanley': unknown parameter 'gain'; remove it",
        ),
        (
            "scenarios: [town]\nfactors: {simple_controller/stanley/k: [1.0, two]}",
            "'simple_controller/stanley/k' must be a number, got two",
        ),
        (
            "scenarios: [town]\nsettings: {sim_options: {frictoin: 0.5}}",
            "sim_options: unknown parameter 'frictoin'; did you mean 'friction'?",
        ),
        (
            "scenarios: [town]\nsettings: {camera: 1}\nfactors: {camera: [0]}\nstack: ros",
            "'camera' is a setting, too; remove one of them",
        ),
        (
            "scenarios: [town]\nsettings: {sim_options: {}, sim_options/friction: 0.5}",
            "'sim_options' contains another setting",
        ),
        (
            "scenarios: [town]\nstack: ros\nsettings: {workspace: ., planner_options: {}}",
            "remove one of them",
        ),
        ("scenarios: [town]\nstack: ros\nsettings: {workspace: no}", "/no does not exist"),
        (
            "scenarios: [town]\nstack: ros\nmetrics: [true_cross_track_rms_m]",
            "is measured in process; remove it or 'stack: ros'",
        ),
        (
            "scenarios: [town]\nseeds: 1000000\nfactors: {planned_speed_mps: [1, 2]}",
            "these are 2000000 drives; at most 1000000 are possible",
        ),
        ("scenarios: [town", "is not valid YAML"),
    ],
)
def test_mistake_is_named_in_one_line(write, content, message):
    path = write(content)
    with pytest.raises(ValueError, match=re.escape(message)) as error:
        load_study(path)
    assert str(error.value).startswith(path)
    assert "\n" not in str(error.value)
