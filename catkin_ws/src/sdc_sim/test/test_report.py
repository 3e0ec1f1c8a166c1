import json
import os

import numpy as np
import pytest

from sdc_package.route import Route
from sdc_sim.drive import Drive, DriveLimits
from sdc_sim.report import ReportError, check_writable, write_report


@pytest.fixture
def drive():
    here = Drive(Route(np.column_stack([np.arange(11.0), np.zeros(11)])), DriveLimits(15.0, 30.0, 2.0, 300.0))
    for tick in range(101):
        here.update(tick * 0.05, tick * 0.1, 0.1, 0.0, 2.0 if tick < 100 else 0.0)
    return here


def test_three_files(tmp_path, drive):
    path = str(tmp_path / "new" / "report.json")
    check_writable(path)
    assert os.listdir(tmp_path / "new") == []
    write_report(path, drive.figures(5.0), drive)
    assert sorted(os.listdir(tmp_path / "new")) == ["report.csv", "report.json", "report.png"]
    with open(path, encoding="utf-8") as file:
        assert json.load(file)["status"] == "completed"
    rows = (tmp_path / "new" / "report.csv").read_text().splitlines()
    assert len(rows) == 102
    assert rows[0].startswith("time_s,x_m,y_m,yaw_rad,speed_mps,s_m,cross_track_m")
    assert float(rows[-1].split(",")[1]) == drive.samples[-1].x_m


def test_an_old_report_is_removed_before_the_drive(tmp_path):
    for name in ("report.json", "report.csv", "report.png"):
        (tmp_path / name).write_text("old")
    check_writable(str(tmp_path / "report.json"))
    assert os.listdir(tmp_path) == []


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    path = str(tmp_path / "file" / "report.json")
    with pytest.raises(ReportError, match="report:=FILE") as caught:
        check_writable(path)
    assert str(tmp_path / "file") in str(caught.value)
