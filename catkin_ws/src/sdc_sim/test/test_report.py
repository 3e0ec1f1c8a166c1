import json
import os
import time

import pytest
from referee_rules import TICK_NS, with_route

from sdc_sim.report.writer import ReportError, open_report, write_pages, write_report


@pytest.fixture
def result():
    evaluator = with_route(length_m=10)
    for tick in range(101):
        speed = 2.0 if tick < 100 else 0.0
        evaluator.add("odometry", tick * TICK_NS, tick * 0.1, 0.1, 0.0, speed)
        evaluator.add("command", tick * TICK_NS, 0.5, 0.0, -0.25)
    return evaluator.result()


def test_report_holds_metrics_and_trace(tmp_path, result):
    path = str(tmp_path / "new" / "report.json")
    open_report(path).remove()
    assert os.listdir(tmp_path / "new") == []
    write_report(path, result)
    assert sorted(os.listdir(tmp_path / "new")) == ["report.csv", "report.json"]
    with open(path, encoding="utf-8") as file:
        assert json.load(file)["status"] == "completed"
    rows = (tmp_path / "new" / "report.csv").read_text().splitlines()
    assert len(rows) == 102
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
