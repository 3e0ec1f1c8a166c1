"""Draws, lateness, scores and isolation of the championship."""

import json
import subprocess
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import psutil
import pytest
import yaml
from distributed import LocalCluster

from sdc_experiments import __main__ as sdc
from sdc_experiments.championship import driver_process
from sdc_experiments.championship.attempt import STORED, new
from sdc_experiments.championship.command import BASELINES, baseline, drive_seeds, graded, source_of
from sdc_experiments.championship.drive import Lateness, drive, drive_seed
from sdc_experiments.championship.driver_process import DriverServer
from sdc_experiments.championship.league import LEAGUES, draw
from sdc_experiments.championship.mission import car_of
from sdc_experiments.championship.score import points
from sdc_experiments.sandbox import SandboxError
from sdc_experiments.sweep.dask_engine import Outcome
from sdc_testing.chromium import check_page, headless_chromium

pytestmark = pytest.mark.slow(40)
TICK_NS, MS = 50_000_000, 1_000_000
ATTACKS = yaml.safe_load(Path(__file__).with_name("championship_attacks.yaml").read_text())
HONEST = """
class Driver:
    def __init__(self, mission):
        self.mission, self.car, self.count = mission, mission.default_car("stanley"), 0

    def step(self, observation):
        self.count += 1
        {}
        return self.car.step(observation)
"""
PROJECT = Path(__file__).resolve().parents[4]


class Hostile:
    """A server of one driver for all attacks: the mission has the name of the attack to make."""

    def __init__(self, server, attack):
        self.server, self.attack = server, attack

    def start(self, mission):
        return self.server.start(replace(mission, league=self.attack))


class InProcess:
    """A server whose drivers are objects of this process that take no time."""

    def __init__(self, make):
        self.make = make

    def start(self, mission):
        self.spent_ns, self.path, self.reason = 0, None, ""
        self.car = car_of(self.make(mission), mission)
        return self

    def step(self, observation):
        return self.car.step(observation)

    def close(self):
        return []


@pytest.fixture(scope="module")
def honest():
    """Return the row of a plain driver on the first seed; skip where there is no sandbox."""
    try:
        with DriverServer(HONEST.format("")) as server:
            return drive_seed(server, "control", "1")
    except SandboxError as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("league", LEAGUES)
def test_equal_seeds_draw_equal_drives_and_others_draw_others(league):
    first, same, other = (draw(league, seed) for seed in ("1", "1", "2"))
    assert first.sim == same.sim != other.sim
    assert np.array_equal(first.route_m, same.route_m)
    assert {name.split("/")[0] for name in LEAGUES[league]["sim"]} <= set(first.sim)


def test_answer_within_its_time_acts_at_once_and_a_late_one_later():
    lateness = Lateness(TICK_NS)
    assert lateness.step(0, 20 * MS) == (0, 1)
    assert lateness.step(1, 21 * MS) == (2, 2)
    assert lateness.step(2, 1 * MS) == (2, 3)
    assert lateness.step(3, 71 * MS) == (5, 4), "it is busy until tick 4 and gets its observation"
    assert lateness.step(4, 5 * MS) == (5, 5), "it starts late"
    assert lateness.step(5, 130 * MS) == (8, 7), "it misses an observation"
    assert lateness.record == [[1, 2, 2], [3, 5, 4], [4, 5, 5], [5, 8, 7]]


@pytest.mark.parametrize("league", LEAGUES)
def test_points_of_good_and_bad_values(league):
    table = LEAGUES[league]["score"]
    assert sum(row[0] for row in table.values()) == 100
    good = points(league, {name: row[1] for name, row in table.items()})
    bad = points(league, {name: row[2] for name, row in table.items()})
    assert sum(good.values()) == pytest.approx(100.0) and sum(bad.values()) == 0.0


def test_drive_in_the_sandbox_repeats_bit_for_bit(honest):
    """The trace is that of the same driver in this process, in which no time is measured."""
    here = drive_seed(InProcess(lambda mission: mission.default_car("stanley")), "control", "1")
    assert honest["trace_sha256"] == here["trace_sha256"]
    assert (honest["score"], honest["points"]) == (here["score"], here["points"])
    assert honest["late"] == []


def test_late_driver_drives_differently_and_its_replay_is_equal(honest):
    busy = "sum(range(12_000_000)) if self.count % 23 == 0 else None"
    with DriverServer(HONEST.format(busy)) as server:
        late = drive_seed(server, "control", "1")
    assert late["late"] and late["trace_sha256"] != honest["trace_sha256"]
    with DriverServer(HONEST.format("")) as server:
        again = drive_seed(server, "control", "1", late["late"])
    assert (again["score"], again["trace_sha256"]) == (late["score"], late["trace_sha256"])


@pytest.fixture(scope="module")
def hostile(honest):
    codes = {name: row["code"] for name, row in ATTACKS.items()}
    code = f"if self.count == 40: exec({codes!r}[self.mission.league])"
    with DriverServer(HONEST.format(code)) as server:
        yield server


@pytest.mark.parametrize("name", ATTACKS)
def test_attack_gains_nothing_and_is_named(name, honest, hostile):
    row = ATTACKS[name]
    found = drive_seed(Hostile(hostile, name), "control", "1")
    assert row["named"] in " ".join([found["problem"], *found["refused"]])
    assert found["score"] == (0.0 if found["problem"] else honest["score"])


def test_import_that_exits_and_dead_code_do_not_end_the_server(honest):
    dead = "\n    def never(self):\n        import unittest.__main__\n"
    with DriverServer(HONEST.format("") + dead) as server:
        assert drive_seed(server, "control", "1")["score"] == honest["score"]
    with DriverServer("-" * 50_000 + "1") as server:
        row = drive_seed(server, "control", "1")
    assert (row["score"], row["problem"][:16]) == (0.0, "it did not start")


def test_server_that_stops_is_given_up_after_its_time(honest, monkeypatch):
    with DriverServer(HONEST.format("")) as server:
        monkeypatch.setattr(driver_process, "_MAX_WALL_S", 2.0)
        for process in psutil.Process().children(recursive=True):
            process.suspend()
        rows = [drive_seed(server, "control", seed) for seed in "12"]
    assert {row["problem"] for row in rows} == {
        "it did not start: the process that starts it has stopped"
    }


def test_driver_whose_task_fails_has_no_result_and_the_others_have(honest, capsys):
    class Engine:
        def outcomes(self, function, tasks):
            for key, _ in tasks:
                yield Outcome(key, [honest], "") if "ada" in key else Outcome(key, None, "killed")

    results = [*graded(Engine(), {"eve": "", "ada": ""}, "control", ["1"])]
    assert [(one["name"], one["score"]) for one in results] == [("ada", honest["score"])]
    assert "eve: not judged: killed" in capsys.readouterr().err


def test_long_expression_is_refused_in_one_line(tmp_path):
    path = tmp_path / "driver.py"
    path.write_text("-" * 50_000 + "1")
    with pytest.raises(ValueError, match=r"driver\.py, line 1: ."):
        source_of(path)


def test_no_drive_finds_what_another_one_left(honest):
    left = "import numpy; assert not hasattr(numpy, 'left') or self.count; numpy.left = 1"
    code = HONEST.format(left)
    with DriverServer(code) as server:
        rows = [drive_seed(server, "control", "1") for _ in range(2)]
    assert rows[0]["trace_sha256"] == rows[1]["trace_sha256"] == honest["trace_sha256"]


def test_observations_hold_nothing_about_the_seed():
    drives = []

    class Watcher:
        def __init__(self, mission):
            self.car = mission.default_car()
            drives.append([mission.first.stamp_ns])
            assert "seed" not in repr(mission)

        def step(self, observation):
            drives[-1].append(observation.stamp_ns)
            return self.car.step(observation)

    draws = [draw("control", str(seed)) for seed in range(1, 10)]
    by_delay = {round(one.sim["sensor_latency_s"] / 0.05): one for one in draws}
    assert len(by_delay) == 2
    for one in by_delay.values():
        drive(InProcess(Watcher), one)
    assert len({tuple(stamps[:300]) for stamps in drives}) == 1
    assert drives[0][:3] == [TICK_NS, TICK_NS, 2 * TICK_NS]


class Memory:
    """Repeats the commands of the public drive whose road begins most like this one."""

    def __init__(self, mission):
        apart = lambda one: np.abs(one[0][:60] - mission.waypoints_m[:60]).sum()  # noqa: E731
        self.commands = min(STORIES, key=apart)[1]
        self.left = iter(self.commands)

    def step(self, observation):
        return next(self.left, self.commands[-1])


STORIES = []


def test_stored_actions_are_no_better_than_pid_and_stanley_on_fresh_seeds():
    class Recorder:
        def __init__(self, mission):
            self.car = mission.default_car("stanley_compensated")
            STORIES.append((mission.waypoints_m, []))

        def step(self, observation):
            STORIES[-1][1].append(self.car.step(observation))
            return STORIES[-1][1][-1]

    public = [drive_seed(InProcess(Recorder), "control", str(seed)) for seed in range(1, 7)]
    known = drive_seed(InProcess(Memory), "control", "3")
    assert known["score"] == public[2]["score"], "on a public seed the actions are as good"
    plain = InProcess(lambda mission: mission.default_car("stanley"))
    for seed in ("fresh 1", "fresh 2", "fresh 3"):
        remembered = drive_seed(InProcess(Memory), "control", seed)["score"]
        assert remembered < 0.2 * drive_seed(plain, "control", seed)["score"]


def test_stored_scores_of_a_baseline_reproduce(honest):
    stored = json.loads(STORED.read_text())["control"]
    assert set(stored) == set(BASELINES)
    rows = drive_seeds(baseline("pure_pursuit"), "control", ["1", "2"], True, {})
    for row in rows:
        assert row["score"] == pytest.approx(stored["pure_pursuit"][row["seed"]], abs=1e-6)


@pytest.mark.parametrize(
    ("name", "needed"),
    [
        ("autoware_mini", "numpy"),
        pytest.param("nonlinear_mpc", "casadi", marks=pytest.mark.nightly),
        ("policy", "gymnasium"),
    ],
)
def test_drivers_of_the_project_drive_in_the_sandbox(name, needed, honest):
    pytest.importorskip(needed)
    (row,) = drive_seeds(baseline(name), "control", ["1"], True, {})
    assert row["status"] == "completed", row["problem"]


def test_documentation_has_the_stored_scores():
    stored = json.loads(STORED.read_text())
    rows = (PROJECT / "docs/championship.md").read_text().splitlines()
    for name in BASELINES:
        cells = next(row for row in rows if f"(`{name}`)" in row).split("|")[2:5]
        for league, cell in zip(LEAGUES, cells):
            scores = stored.get(league, {}).get(name, {})
            assert cell.split()[0] == (f"{np.mean([*scores.values()]):.1f}" if scores else "-")


def test_new_driver_is_tried_from_a_terminal(tmp_path, honest, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert new(SimpleNamespace(file="mine.py")) == 0
    assert len(Path("mine.py").read_text().split("class Driver")[1].splitlines()) <= 10
    command = ["python3", "-m", "sdc_experiments", "championship", "try", "mine.py", "drives:=2"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    last = done.stdout.splitlines()[-1]
    assert done.returncode == 0, done.stderr
    assert last.startswith("championship: control: score ") and f"of {len(BASELINES) + 1}" in last
    page = Path("report/championship/mine.html").read_text()
    assert "The worst drive" in page and "srcdoc" in page
    size = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with LocalCluster(**size) as cluster:
        words = ["sdc", "championship", "try", "mine.py", "replay:=report/championship/mine.json"]
        monkeypatch.setattr("sys.argv", [*words, "--scheduler", cluster.scheduler_address])
        assert sdc.main() == 0
    assert capsys.readouterr().out.splitlines()[-1] == last
    with headless_chromium() as browser:
        check_page(browser, Path("report/championship/mine.html").resolve().as_uri())
