import json
import os

import numpy as np
import pytest
import yaml

from sdc_sim.evaluation.evaluator import EvaluationRules, Evaluator
from sdc_sim.report.writer import ReportError, open_report, write_report

with open(
    os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "config", "referee.yaml"),
    encoding="utf-8",
) as config:
    RULES = EvaluationRules.read(yaml.safe_load(config).get)


@pytest.fixture
def result():
    watch = Evaluator(RULES)
    watch.mission(np.column_stack([np.arange(11.0), np.zeros(11)]))
    for tick in range(101):
        watch.odometry(tick * 50_000_000, tick * 0.1, 0.1, 0.0, 2.0 if tick < 100 else 0.0)
        watch.command(tick * 50_000_000, 0.5, 0.0, -0.25)
    return watch.result()


def test_figures_and_trace(tmp_path, result):
    path = str(tmp_path / "new" / "report.json")
    open_report(path, "drive").remove()
    assert os.listdir(tmp_path / "new") == []
    write_report(path, result)
    assert sorted(os.listdir(tmp_path / "new")) == ["report.csv", "report.json"]
    with open(path, encoding="utf-8") as file:
        assert json.load(file)["status"] == "completed"
    rows = (tmp_path / "new" / "report.csv").read_text().splitlines()
    assert len(rows) == 102
    assert (
        rows[0]
        == "time_s,x_m,y_m,yaw_rad,speed_mps,s_m,cross_track_m,heading_error_rad,throttle,brake,steer"
    )
    assert float(rows[-1].split(",")[1]) == result.drive.samples[-1].x_m
    assert rows[-1].split(",")[8:] == ["0.5", "0.0", "-0.25"]


def test_an_old_report_is_removed_before_the_drive(tmp_path):
    for name in ("report.json", "report.csv", "report.png", "report.html"):
        (tmp_path / name).write_text("old")
    open_report(str(tmp_path / "report.json"), "drive").remove()
    assert os.listdir(tmp_path) == []


def test_the_journal_of_this_drive_is_no_old_report(tmp_path):
    path = str(tmp_path / "report.json")
    open_report(path, "drive").write(["command", 1])
    assert list(open_report(path, "drive").events()) == [["command", 1]]
    assert list(open_report(path, "another").events()) == []


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    path = str(tmp_path / "file" / "report.json")
    with pytest.raises(ReportError, match="report:=FILE") as caught:
        open_report(path, "drive")
    assert str(tmp_path / "file") in str(caught.value)


def test_a_folder_that_vanished_is_made_again(tmp_path, result):
    path = tmp_path / "gone" / "report.json"
    write_report(str(path), result)
    assert path.exists()


def test_a_report_that_cannot_be_written_leaves_none(tmp_path, result):
    (tmp_path / "report.json.part").mkdir()
    with pytest.raises(ReportError, match="not reported"):
        write_report(str(tmp_path / "report.json"), result)
    assert not (tmp_path / "report.json").exists()
