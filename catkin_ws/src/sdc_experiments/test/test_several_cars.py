"""Several cars in one world: each has its own report."""

import json
import os
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

from sdc_common.configuration import package_folder
from sdc_common.driving import Command
from sdc_common.processes import isolated_ros_environment
from sdc_experiments.several_cars import drive_cars
from sdc_sim.evaluation.drive_evaluation import COLUMNS
from sdc_sim.report.writer import write_report
from sdc_testing.program import run

DRIVE = str(Path(__file__).resolve().parents[4] / "drive")
ROUTE = [{"straight_m": 60}, {"left_deg": 60, "radius_m": 30, "transition_m": 10}]


class Constant:
    """A driver that gives one command."""

    path, reason = None, ""

    def __init__(self, **command):
        self._command = Command(**command)

    def step(self, observation):
        return self._command


def traces(results):
    return {name: result.rows.tobytes() for name, result in results.items()}


@pytest.mark.slow(2)
def test_cars_follow_each_other_to_the_end_and_repeat_bit_for_bit():
    results = drive_cars(route=ROUTE, cars=3)
    assert [one.metrics["status"] for one in results.values()] == ["completed"] * 3
    ends_s = [one.metrics["duration_s"] for one in results.values()]
    assert ends_s == sorted(ends_s, reverse=True), "the last car arrives last"
    assert "obstacle" in results["ego_vehicle"].reasons
    assert "obstacle" not in results["hero2"].reasons, "no car is ahead of it"
    assert traces(drive_cars(route=ROUTE, cars=3)) == traces(results)


def test_car_stops_behind_a_standing_one_and_drives_on_when_that_drive_has_ended():
    options = {"sim_options": {"next_car": {"along_m": 30.0}}, "referee_options": {"blocked_s": 10}}
    results = drive_cars(route=ROUTE, drivers={"hero1": Constant(brake=1.0)}, **options)
    own, other = results["ego_vehicle"], results["hero1"]
    assert (own.metrics["status"], other.metrics["status"]) == ("completed", "blocked")
    waits = [row for row, speed in zip(own.rows, own.progress.column("speed_mps")) if speed < 0.05]
    gaps = [30.0 - 4.7 - row[COLUMNS.index("s_m")] for row in waits if 5.0 < row[0] < 10.0]
    assert gaps and all(4.5 < gap < 6.5 for gap in gaps)


@pytest.mark.slow(25)
@pytest.mark.parametrize(
    ("left_m", "statuses"),
    [
        (0.0, ["completed"] * 2),
        pytest.param(2.5, ["collision", "collision", "completed"], marks=pytest.mark.nightly),
    ],
)
def test_nodes_drive_as_the_library_and_each_car_has_its_report(tmp_path, left_m, statuses):
    cars = len(statuses)
    (tmp_path / "short.yaml").write_text(json.dumps({"route": ROUTE}))
    next_car = {"along_m": 0.0, "left_m": left_m} if left_m else {"along_m": 12.0}
    options = ["scenario:=short.yaml", f"cars:={cars}", f"sim_options:={{next_car: {next_car}}}"]
    options += ["sync:=true", "camera:=false", "referee_options:={pictures: false}"]
    with isolated_ros_environment(tmp_path / "ros") as environment:
        command = DRIVE, "headless:=true", *options
        done = run(*command, folder=tmp_path, environment=environment)
    assert (done.returncode == 0) == (statuses[0] == "completed"), done.stdout
    results = drive_cars(route=ROUTE, cars=cars, sim_options={"next_car": next_car})
    names = {"ego_vehicle": "report", "hero1": "report_hero1", "hero2": "report_hero2"}
    assert [one.metrics["status"] for one in results.values()] == statuses
    for name, result in results.items():
        write_report(str(tmp_path / "library.json"), result)
        path = tmp_path / "report" / names[name]
        assert path.with_suffix(".csv").read_text() == (tmp_path / "library.csv").read_text()
        report = json.loads(path.with_suffix(".json").read_text())
        assert {**report, "wall_duration_s": None, "real_time_factor": None} == result.metrics
    report = tmp_path / "report" / "report.json"
    assert report.with_name("report_ego_vehicle.json").read_text() == report.read_text()


def test_group_of_a_car_replaces_all_topics_of_its_nodes_and_its_referee():
    """Those of the world stay, and with `truth: false` there is one car."""
    package, world = (package_folder(name) for name in ("sdc_package", "sdc_sim"))
    tree = ElementTree.parse(os.path.join(package, "launch", "hero.launch"))
    remapped = {one.get("from") for one in tree.iter("remap")}
    with open(os.path.join(world, "config", "record.yaml"), encoding="utf-8") as file:
        topics = set(yaml.safe_load(file)["topics"])
    for folder, _, files in os.walk(os.path.join(package, "scripts")):
        for file in (one for one in files if one.endswith(".py")):
            with open(os.path.join(folder, file), encoding="utf-8") as script:
                topics |= set(re.findall(r'"(/[a-z_]+/[a-z_/]+)"', script.read()))
    world_s = re.compile("/carla/(traffic|objects|markers)|/clock|/tf|/sim/|/stack/")
    of_world = {one for one in topics if world_s.match(one)}
    assert topics - of_world - remapped == set()
    for one in tree.iter("remap"):
        place = "$(arg ego)" if "/ego_vehicle/" in one.get("from") else "$(arg folder)"
        assert one.get("to") == place + one.get("from").replace("/carla/ego_vehicle", "")
