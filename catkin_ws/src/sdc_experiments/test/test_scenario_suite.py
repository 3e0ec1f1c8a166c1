"""./scenarios: drives of scenario types, their scores, and the page."""

import contextlib
import io
import json
import subprocess
from html import escape
from pathlib import Path

import pytest
from distributed import LocalCluster

from sdc_common.configuration import package_folder
from sdc_experiments.__main__ import main
from sdc_experiments.closed_loop import drive
from sdc_experiments.commands import parse
from sdc_experiments.scenarios import NAIVE, OWN, picture_of, row_of, run, summary
from sdc_map.map_file import map_file
from sdc_sim.scenario.street_scenarios import types
from sdc_testing.chromium import check_page, headless_chromium
from sdc_testing.street_maps import needs_maps

ROOT = Path(__file__).resolve().parents[4]
NAMES = ["DynamicObjectCrossing", "ParkedObstacle"]


def run_words(*words):
    return run(parse("scenarios", words))


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """Drive on a cluster whose worker is this process; return status, printed lines and page."""
    page, printed = tmp_path_factory.mktemp("suite") / "page.html", io.StringIO()
    size = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with LocalCluster(**size) as cluster, contextlib.redirect_stdout(printed):
        options = ["seeds:=7-7", "naive:=1", "--scheduler", cluster.scheduler_address]
        status = run_words(*NAMES, f"report:={page}", *options)
        assert cluster.scheduler.transition_log, "the cluster had the tasks"
    return status, printed.getvalue().splitlines(), page


@needs_maps
@pytest.mark.slow(20)
def test_types_are_driven_scored_and_shown(driven):
    status, printed, page = driven
    result = json.loads(page.with_suffix(".json").read_text())
    assert status == (1 if result["broken"] else 0)
    assert printed[-1].startswith("scenarios: 2 drives of 2 types, driving score ")
    assert page.with_suffix(".csv").read_text().count("\n") == 5
    rows = {(row["type"], row["driver"]): row for row in result["rows"]}
    crossing = rows["DynamicObjectCrossing", NAIVE]
    assert crossing["infractions"].startswith("collision_pedestrian") and not crossing["success"]
    parked = rows["ParkedObstacle", NAIVE]
    assert parked["status"] in ("blocked", "too_late") and not parked["infractions"]
    assert rows["ParkedObstacle", OWN]["trace_sha256"] != parked["trace_sha256"]
    text = page.read_text(encoding="utf-8")
    for name in NAMES:
        about = escape(types()[name]["about"]).replace("&#x27;", "&#39;")
        assert f"plan of {name}" in text and about in text
    assert text.count("<iframe") == 2 and text.count("slider-data") >= 2
    with headless_chromium() as browser:
        check_page(browser, page.as_uri())


@needs_maps
@pytest.mark.nightly
@pytest.mark.slow(30)
def test_nodes_of_a_stack_are_driven_and_scored(tmp_path, capsys):
    stack = Path(package_folder("sdc_package")) / "launch" / "stack.launch"
    name, page = "VanillaSignalizedTurnEncounterRedLight", tmp_path / "page.html"
    assert run_words(name, "seeds:=1", "naive:=0", f"stack:={stack}", f"report:={page}") == 0
    assert capsys.readouterr().out.splitlines()[-1].startswith("scenarios: 1 drives of 1 types")
    (row,) = json.loads(page.with_suffix(".json").read_text())["rows"]
    assert row["driver"] == str(stack) and row["status"] == "completed"
    assert "red_light" not in row["infractions"] and row["route_completion_percent"] == 100.0
    report = json.loads((tmp_path / f"{name}_1.json").read_text())
    assert report["missed_ticks"] == 0 and report["ticks"] > 200
    assert page.read_text(encoding="utf-8").count("<iframe") == 1


def row(name, seed, driver, success):
    infractions = {"collision_vehicle": not success, "near_miss": 0}
    metrics = {"status": "completed", "driving_score": 100.0 if success else 60.0}
    metrics.update(infractions=infractions, route_completion_percent=100.0, duration_s=30.0)
    return row_of(name, seed, driver, 40.0, {**metrics, "off_lane_percent": 0.0}, b"")


@pytest.mark.parametrize(
    ("own", "naive", "broken"),
    [
        ((1, 1, 1, 0), (0, 0), {}),
        ((1, 1), (1, 1, 0), {"Accident": "pass"}),
        ((0, 0), (0,), {"Accident": "fail"}),
    ],
)
def test_type_that_both_drivers_pass_or_fail_is_broken(own, naive, broken):
    rows = [row("Accident", seed, OWN, one) for seed, one in enumerate(own)]
    rows += [row("Accident", seed, NAIVE, one) for seed, one in enumerate(naive)]
    result = summary(rows)
    assert result["broken"] == broken
    assert result["success_percent"] == 100.0 * sum(own) / len(own)
    low, high = result["success_interval_percent"]
    assert 0.0 <= low <= result["success_percent"] <= high <= 100.0 and high - low > 20.0
    assert result["abilities"]["Overtaking"]["drives"] == len(own)
    assert result["types"]["Accident"]["naive"]["drives"] == len(naive)


@pytest.mark.parametrize(
    ("changed", "status"),
    [
        ({}, "completed"),
        ({"duration_s": 40.1}, "too_late"),
        ({"status": "aborted"}, "too_late"),
        ({"driving_score": 99.0, "off_lane_percent": 1.0}, "completed"),
        ({"status": "blocked", "driving_score": 100.0}, "blocked"),
    ],
)
def test_success_is_a_route_completed_in_time_with_the_full_score(changed, status):
    metrics = {"status": "completed", "driving_score": 100.0, "duration_s": 40.0}
    metrics.update(infractions={"near_miss": 1}, route_completion_percent=100.0)
    metrics["off_lane_percent"] = 0.0
    found = row_of("Accident", 1, OWN, 40.0, {**metrics, **changed}, b"")
    assert found["status"] == status and found["success"] == (not changed)
    is_off = changed.get("off_lane_percent", 0.0) > 0.0
    assert found["infractions"] == "near_miss" + " off_lane" * is_off


def test_reversed_range_of_seeds_is_one_line(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["sdc", "scenarios", "seeds:=5-4"])
    assert main() == 2
    errors = capsys.readouterr().err
    assert errors == "scenarios: seeds:=5-4: must be a number, or FIRST-LAST\n"


@pytest.mark.slow(2)
def test_command_lists_the_types():
    listed = subprocess.run([ROOT / "scenarios", "--list"], capture_output=True, text=True)
    lines = listed.stdout.splitlines()[-len(types()) :]
    assert [line.split(":")[0] for line in lines] == [*types()]


def test_unknown_lack_is_refused():
    with pytest.raises(ValueError, match="lacking: must be one of .*obstacles.*, got 'brakes'"):
        drive(lacking="brakes")


@pytest.mark.slow(3)
@needs_maps
def test_plan_of_a_type_has_the_car_on_its_route_towards_the_right():
    plan = picture_of("ParkingCutIn", map_file("town"), 1, {})
    (place,), degrees, length_m, width_m = plan["boxes"][-1]
    assert max(map(abs, place)) < 20.0 and abs(degrees) < 20.0 and (length_m, width_m) == (4.7, 2.0)
    route = plan["route"]
    assert min(x * x + y * y for x, y in route) < 4.0 and route[0][0] < 0.0 < route[-1][0]
    assert plan["tracks"] and any(line for line, _ in plan["lanes"])
