"""The experiments of phase 4: what a check answers, and that each shows what it explains."""

import json
import math

import pytest
import yaml
from guide_blocks import read
from guide_student import GUIDE

from sdc_experiments.closed_loop import drive
from sdc_package.steering import stanley_compensated
from sdc_workshop.exam.experiment import Experiment, table
from sdc_workshop.steps import all_steps, chosen

ROUTES = {
    block.file: yaml.safe_load(block.text)["elements"]
    for block in read(GUIDE[-1].read_text(encoding="utf-8"))
    if block.does == "write" and (block.file or "").endswith("_route.yaml")
}
MY_ROUTE, TIGHT_ROUTE = ROUTES["my_route.yaml"], ROUTES["tight_route.yaml"]
NOISE = {"position_m": 0.1, "heading_rad": 0.0, "speed_mps": 0.0}
K_60 = {"stanley_compensated": {"k": 60.0}}
# Of each experiment: how the drive differs, its parameters, and the choice that is right.
DRIVES = {
    "experiment-1": ({"controller_options": {"stanley_compensated": {"k": 60.0}}}, "c"),
    "experiment-2": ({"sim_options": {"command_latency_s": 0.3}}, "a"),
    "experiment-3": ({"sim_options": {"odometry_noise": NOISE}}, "b"),
    "experiment-4": ({"sim_options": {"friction": 0.6}}, "a"),
    "experiment-5": ({}, "c"),
    "experiment-6": ({"route": TIGHT_ROUTE}, "b"),
    "experiment-7": ({"sim_options": {"vehicle": "vw_vanagon"}}, "a"),
}


@pytest.fixture(scope="module")
def my_route():
    return drive(route=MY_ROUTE)


def keep(folder, name, report, options):
    """Write the report and the parameters of a drive, as the referee does."""
    route = "/ws/tight_route.csv" if "route" in options else "/ws/my_route.csv"
    parameters = {
        "sim": {"friction": 1.0, **options.get("sim_options", {}), "waypoints_path": route},
        "mission_planner": {"waypoints_path": route},
        "referee": {"report": f"report/{name}.json"},
        "simple_controller": options.get("controller_options", {}),
    }
    (folder / "report").mkdir(exist_ok=True)
    (folder / "report" / f"{name}.json").write_text(json.dumps(report))
    (folder / "report" / f"{name}.parameters.json").write_text(json.dumps(parameters))


def with_plus(sign):
    """Return Stanley's law with a plus, and with a sign of the heading error."""
    return lambda heading, error, speed, k, softening=0.0: (
        sign * heading + math.atan2(k * error, softening + abs(speed))
    )


def predict(folder, name, letter):
    with (folder / "predictions.yaml").open("a") as file:
        file.write(f"{name}: {letter}\n")


@pytest.mark.slow(2)
@pytest.mark.parametrize("name", DRIVES)
def test_result_is_what_the_experiment_explains(name, my_route, tmp_path, monkeypatch):
    options, right = DRIVES[name]
    others = [my_route]
    if name == "experiment-5":
        monkeypatch.setattr(stanley_compensated, "stanley_angle", with_plus(-1))
        others.append(drive(route=MY_ROUTE))
        monkeypatch.setattr(stanley_compensated, "stanley_angle", with_plus(1))
    experiment = Experiment.named(name, tmp_path)
    keep(tmp_path, "my_route", my_route, {})
    assert experiment.answer().status == "unfinished", "there is no prediction"
    predict(tmp_path, name, "a")
    assert f"report/{name}.json" in experiment.answer().expected
    for report in others:
        keep(tmp_path, name, report, {})
        assert experiment.answer().status == "wrong", "another drive is no experiment"
        assert experiment.setting in experiment.answer().expected
    keep(tmp_path, name, drive(**{"route": MY_ROUTE, **options}), options)
    for prediction in "abc":
        predict(tmp_path, name, prediction)
        answer = experiment.answer()
        assert answer.status == "passed", "a wrong prediction passes, too"
        assert answer.expected.startswith(f"{prediction}: ")
        assert answer.seen.startswith(f"{right}: ")
        assert answer.hint.startswith("As" if prediction == right else "Not as")


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        (
            "experiment-2",
            {"controller_options": K_60},
            ["stanley_compensated/k is 60.0", "config/"],
        ),
        ("experiment-4", {"route": TIGHT_ROUTE}, ["waypoints_path is tight_route.csv", "command"]),
        ("experiment-4", {"sim_options": {"vehicle": "van"}}, ["sim/friction is 1.0", "command"]),
        (
            "experiment-1",
            {"controller_options": {"stanley": {"k": 60.0}}},
            [
                "simple_controller/stanley/k is 60.0",
                "must be in simple_controller/stanley_compensated",
            ],
        ),
    ],
)
def test_all_else_is_equal(name, options, words, tmp_path):
    experiment = Experiment.named(name, tmp_path)
    base = {"stanley_compensated": {"k": 2.5}, "stanley": {"k": 2.5}}
    changed = {**base, **options.get("controller_options", {})}
    report = {experiment.metric: 1.0, "status": "completed"}
    settings = dict(experiment.changes)
    sim = {key[4:]: value for key, value in settings.items() if "vehicle" not in str(options)}
    sim = {} if name == "experiment-1" else sim
    keep(tmp_path, "my_route", report, {"controller_options": base})
    every = {**options, "controller_options": changed}
    every["sim_options"] = {**sim, **options.get("sim_options", {})}
    keep(tmp_path, name, report, every)
    predict(tmp_path, name, "a")
    answer = experiment.answer()
    assert answer.status == "wrong"
    for word in words:
        assert word in f"{answer.seen} {answer.hint}"


def test_guide_asks_what_the_check_asks():
    guide = " ".join(GUIDE[-1].read_text(encoding="utf-8").split())
    for row in table().values():
        for text in (row["question"], *(f"- {key}: {one}" for key, one in row["choices"].items())):
            assert text in guide


def test_experiments_are_optional():
    assert [step.id for step in all_steps() if step.optional] == list(table()) == list(DRIVES)
    assert not [step for step in chosen([]) if step.optional]
    assert [step.id for step in chosen(["experiment"])] == list(DRIVES)
