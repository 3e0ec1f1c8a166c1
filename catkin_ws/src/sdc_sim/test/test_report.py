"""The files of a report: written at once, and completed from the file of events."""

import json
import os
import subprocess
import time

import pytest
from referee_rules import TICK_NS, with_route

from sdc_sim.report.writer import (
    EVENTS,
    ReportError,
    companion,
    complete_report,
    is_complete,
    open_report,
    write_pages,
    write_report,
)

HERE = os.path.dirname(os.path.abspath(__file__))
SCRIPT = os.path.join(HERE, "..", "scripts", "report.py")
PARTS = ["report.csv", "report.html", "report.json", "report.png"]


@pytest.fixture
def path(tmp_path):
    return str(tmp_path / "report.json")


def driven(path="", ticks=100):
    """Return the evaluator of a drive, whose events are in a file beside the path or in memory."""
    evaluator = with_route(open_report(path) if path else None, 10)
    evaluator.add("lights", TICK_NS, [(7, 0)])
    for tick in range(1, ticks + 1):
        speed = 2.0 if tick < 100 else 0.0
        evaluator.add("odometry", tick * TICK_NS, tick * 0.1, 0.1, 0.0, speed, 0.01 * tick)
        evaluator.add("command", tick * TICK_NS, 0.5, 0.0, -0.25)
    evaluator.add("snapshot", 1.0, 20.0, "YSBwaWN0dXJl")
    return evaluator


@pytest.fixture
def result():
    return driven().result()


def completed(folder):
    return subprocess.run(
        [SCRIPT, str(folder)], capture_output=True, text=True, timeout=120.0, check=False
    )


@pytest.mark.slow(5)
def test_report_of_a_killed_referee_covers_every_tick_until_then(path, tmp_path):
    driven(path, ticks=60)
    with open(companion(path, EVENTS), "ab") as file:
        file.write(b'["odometry", 30500')  # the referee was killed while it wrote
    done = completed(tmp_path)
    assert done.returncode == 0, done.stderr
    assert sorted(os.listdir(tmp_path)) == PARTS
    report = json.loads((tmp_path / "report.json").read_text())
    assert (report["status"], report["ticks"], report["ticks_by_stamp"]) == ("aborted", 60, 60)
    assert (report["referee_restarts"], report["world_restarts"]) == (0, 0)
    write_report(str(tmp_path / "memory.json"), driven(ticks=60).result())
    assert json.loads((tmp_path / "memory.json").read_text()) == report
    assert (tmp_path / "memory.csv").read_bytes() == (tmp_path / "report.csv").read_bytes()
    assert "data:image/jpeg" in (tmp_path / "report.html").read_text()
    again = completed(tmp_path)
    assert (again.returncode, "nothing is missing" in again.stdout) == (0, True)


@pytest.mark.slow(3)
def test_metrics_that_are_there_stay(path, tmp_path):
    write_report(path, driven(path).result())
    before = (tmp_path / "report.json").read_text()
    complete_report(path)
    assert (tmp_path / "report.json").read_text() == before
    assert sorted(os.listdir(tmp_path)) == PARTS
    assert "0.990" in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize(
    ("events", "message"),
    [(None, "No such file"), ("", "the drive has no route"), ("nonsense\n", "Expecting value")],
)
def test_report_without_usable_events_is_refused_in_one_line(tmp_path, events, message):
    if events is not None:
        (tmp_path / "report.events.jsonl").write_text(events)
    done = completed(tmp_path)
    assert done.returncode == 1
    assert message in done.stderr
    assert "report.events.jsonl" in done.stderr
    assert done.stderr.count("\n") == 1


def test_error_of_a_page_is_reported(path, tmp_path):
    driven(path)
    (tmp_path / "report.png").mkdir()
    with pytest.raises(ReportError, match="the pages are not"):
        complete_report(path)
    assert not is_complete(path), "the next call can complete it"


def test_report_holds_metrics_and_trace(tmp_path, result):
    path = str(tmp_path / "new" / "report.json")
    open_report(path).remove()
    assert os.listdir(tmp_path / "new") == []
    write_report(path, result)
    assert sorted(os.listdir(tmp_path / "new")) == ["report.csv", "report.json"]
    with open(path, encoding="utf-8") as file:
        assert json.load(file)["status"] == "completed"
    rows = (tmp_path / "new" / "report.csv").read_text().splitlines()
    assert len(rows) == 101
    motion = "time_s,x_m,y_m,yaw_rad,speed_mps,s_m,cross_track_m,heading_error_rad"
    assert rows[0] == motion + ",throttle,brake,steer,reason"
    assert float(rows[-1].split(",")[1]) == result.progress.samples[-1].x_m
    assert rows[-1].split(",")[8:] == ["0.5", "0.0", "-0.25", ""]


def test_old_report_is_removed_before_the_drive(tmp_path):
    for name in ("report.json", "report.csv", "report.png", "report.html"):
        (tmp_path / name).write_text("old")
    open_report(str(tmp_path / "report.json")).remove()
    assert os.listdir(tmp_path) == []


def test_error_names_the_file_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    path = str(tmp_path / "file" / "report.json")
    with pytest.raises(ReportError, match="report:=FILE") as caught:
        open_report(path)
    assert str(tmp_path / "file") in str(caught.value)


def test_failed_write_leaves_no_report(tmp_path, result):
    (tmp_path / "report.json.part").mkdir()
    with pytest.raises(ReportError, match="not reported"):
        write_report(str(tmp_path / "report.json"), result)
    assert not (tmp_path / "report.json").exists()


@pytest.mark.parametrize("extension", [".png", ".html"])
def test_page_is_complete_or_absent(tmp_path, result, extension):
    (tmp_path / f"report{extension}.part").mkdir()
    with pytest.raises(ReportError, match=f"report{extension}.part.*the pages are not"):
        write_pages(str(tmp_path / "report.json"), result)
    assert not (tmp_path / f"report{extension}").exists()


@pytest.mark.slow(2)
@pytest.mark.parametrize(
    ("sim", "way"),
    [
        (
            {"street_scenario": "", "obstacles_path": "/a/crossing.yaml", "map_path": "b"},
            "crossing",
        ),
        ({"obstacles_path": "", "map_path": "", "waypoints_path": "/a/oval.csv"}, "oval"),
    ],
)
def test_title_names_what_was_driven_how_and_when(tmp_path, result, sim, way):
    parameters = {"sim": sim, "simple_controller": {"steering_method": "lqr"}}
    (tmp_path / "report.parameters.json").write_text(json.dumps(parameters))
    os.utime(tmp_path / "report.parameters.json", (0, 0))
    write_pages(str(tmp_path / "report.json"), result)
    page = (tmp_path / "report.html").read_text()
    date = time.strftime("%Y-%m-%d %H:%M", time.localtime(0))
    assert f"<title>{way}, lqr, {date}: completed</title>" in page
