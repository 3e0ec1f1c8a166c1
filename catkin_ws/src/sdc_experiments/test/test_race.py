"""./championship race: drivers in sandboxes of their own, in one world."""

import json
from contextlib import ExitStack

import pytest

from sdc_experiments.__main__ import main
from sdc_experiments.championship import race
from sdc_experiments.championship.driver_process import DriverServer
from sdc_testing.chromium import check_page, headless_chromium, value_of

pytestmark = pytest.mark.slow(30)

OURS = """class Driver:
    def __init__(self, mission):
        self.step = mission.default_car().step
"""
# It computes for longer than a step lasts, once.
LATE = """class Driver:
    def __init__(self, mission):
        self.car, self.steps = mission.default_car("lqr"), 0

    def step(self, observation):
        self.steps += 1
        if self.steps == 60:
            sum(range(10_000_000))
        return self.car.step(observation)
"""
# It waits until it sees the car that was behind it, and then ends.
ENDS = """class Driver:
    def __init__(self, mission):
        self.ids = {one.id for one in mission.first.obstacles}

    def step(self, observation):
        assert len(self.ids) == 2 and {one.kind for one in observation.obstacles} == {"car"}
        if observation.stamp_s > 3.0:
            raise ValueError("no fuel")
"""


@pytest.fixture(autouse=True)
def short(monkeypatch):
    monkeypatch.setattr(race, "_ROUTE", {"length_m": 150.0, "least_radius_m": 20.0})


def test_result_does_not_depend_on_the_order_and_a_record_repeats_it():
    sources = {"ours": OURS, "late": LATE, "ends": ENDS}
    with ExitStack() as stack:
        made = {name: DriverServer(source, sandboxed=False) for name, source in sources.items()}
        servers = {name: stack.enter_context(server) for name, server in made.items()}
        rows, _ = race.drive_race(servers, "2")
        record = {row["driver"]: row["late"] for row in rows}
        assert record["late"] and not record["ours"]
        again, _ = race.drive_race({name: servers[name] for name in sorted(sources)}, "2", record)
    for row in (*rows, *again):
        del row["step_p99_ms"]
    assert again == rows
    assert [row["status"] for row in rows] == ["completed", "completed", "driver ended"]
    assert rows[0]["duration_s"] < rows[1]["duration_s"]
    assert rows[2]["problem"] == "line 8: ValueError: no fuel"
    assert {row["car"] for row in rows} == {"ego_vehicle", "hero1", "hero2"}
    assert sorted(row["start_place"] for row in rows) == [1, 2, 3]


def test_page_shows_all_cars_at_any_time(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ours.py").write_text(OURS)
    (tmp_path / "ends.py").write_text(ENDS.replace("== 2", "== 1"))
    options = ["seed:=3", "sandbox:=false"]
    monkeypatch.setattr("sys.argv", ["sdc", "championship", "race", "ours.py", "ends.py", *options])
    assert main() == 1
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith("race: 1. ours: ")
    assert printed[2] == "race: ends: line 8: ValueError: no fuel"
    page = tmp_path / "report" / "race.html"
    assert printed[-1] == "championship: race: ours of 2 wins on seed 3; see report/race.html"
    rows = json.loads(page.with_suffix(".json").read_text())["rows"]
    with headless_chromium() as browser:
        browser.get(f"file://{page}")
        picture = "document.getElementById('near').toDataURL()"
        first = value_of(browser, picture)
        slider = "const slider = document.getElementById('time');"
        browser.execute_script(f"{slider} slider.value = slider.max; slider.oninput()")
        assert value_of(browser, picture) != first
        clock = value_of(browser, "document.getElementById('clock').textContent")
        assert float(clock.split()[0]) == pytest.approx(rows[0]["duration_s"], abs=0.11)
        assert value_of(browser, "document.getElementById('now1').textContent") == "-"
        assert browser.get_log("browser") == []
        check_page(browser, page.as_uri())


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["a.py"], "race: name two to eight drivers"),
        (["a.py"] * 9, "race: name two to eight drivers"),
        (["a.py", "b.launch"], "race: name two to eight drivers"),
        (["a.py", "b.py", "sead:=2"], "unknown argument 'sead:=2'; did you mean 'seed'"),
        (["a.py", "c.py"], "'c.py': there is no such file"),
        (["a.py", "b.py"], "a.py, line 1: "),
    ],
)
def test_mistake_is_one_line(tmp_path, monkeypatch, capsys, arguments, line):
    monkeypatch.chdir(tmp_path)
    for name in ("a.py", "b.py", "b.launch"):
        (tmp_path / name).write_text("class :")
    monkeypatch.setattr("sys.argv", ["sdc", "championship", "race", *arguments])
    assert main() == 2
    seen = capsys.readouterr()
    assert seen.err.startswith("championship: ") and line in seen.err and seen.out == ""
    assert seen.err.count("\n") == 1
