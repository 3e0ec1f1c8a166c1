"""./workshop/check my-car: score, place and worst drive of a student's own car."""

import json
from pathlib import Path

import pytest

from sdc_workshop import my_car, progress
from sdc_workshop.workspace import WorkspaceError, make

BASELINES = {"control": {"a": 90.0, "b": 70.0, "c": 99.0}, "driving": {"a": 80.0, "b": 60.0}}
SCORES = {"control": (90.0, 70.0), "driving": (60.0, 80.0)}


@pytest.fixture
def folder(tmp_path):
    make(tmp_path / "ws")
    return tmp_path / "ws"


def drive(monkeypatch, scores, problem=""):
    """Let the championship write these scores of two drives, and no record for None."""
    asked = []

    def run(command, **_):
        words = dict(word.split(":=") for word in command[3:])
        asked.append((words["league"], words["drives"]))
        of_drives = scores[words["league"]]
        if of_drives:
            found = {
                "league": words["league"],
                "score": sum(of_drives) / 2,
                "rows": [{"score": score, "problem": problem} for score in of_drives],
                "baselines": BASELINES[words["league"]],
            }
            report = Path(words["report"])
            report.mkdir(parents=True, exist_ok=True)
            (report / "driver.json").write_text(json.dumps(found))
        return my_car.subprocess.CompletedProcess(command, int(not of_drives or problem > ""))

    monkeypatch.setattr(my_car.subprocess, "run", run)
    return asked


def test_my_car_shows_score_place_worst_drive_and_keeps_the_best(folder, monkeypatch, capsys):
    (folder / "driver.py").write_text("class Driver: pass\n")
    asked = drive(monkeypatch, SCORES)
    assert my_car.run(2, folder / "src") == 0
    assert asked == [("control", "2"), ("driving", "2")]
    shown = capsys.readouterr().out
    assert "my-car: 75.0 of 100 (control 80.0, driving 70.0)" in shown
    assert "my-car: place 2 of 3," in shown, "c drives in one league alone"
    assert f"the worst drive: {folder.as_uri()}/report/my-car/driving/driver.html" in shown
    drive(monkeypatch, {"control": (50.0, 50.0), "driving": (50.0, 50.0)})
    assert my_car.run(2, folder) == 0
    assert "my-car: 50.0 of 100" in (shown := capsys.readouterr().out)
    assert "your best is 75.0" in shown
    assert progress.best_car(folder) == 75.0 and progress.statuses(folder) == {}


def test_my_car_that_cannot_be_measured_keeps_nothing(folder, monkeypatch):
    with pytest.raises(WorkspaceError, match="championship new driver.py` writes one"):
        my_car.run(2, folder)
    (folder / "driver.py").write_text("class Driver: pass\n")
    drive(monkeypatch, {"control": (), "driving": ()})
    assert my_car.run(2, folder) == 1
    assert progress.best_car(folder) is None


def test_my_car_stops_after_a_league_in_which_no_drive_worked(folder, monkeypatch, capsys):
    (folder / "driver.py").write_text("class Driver: pass\n")
    asked = drive(monkeypatch, SCORES, problem="it did not start: line 5: no attribute 'heading'")
    assert my_car.run(2, folder) == 1
    assert asked == [("control", "2")] and progress.best_car(folder) is None
    assert capsys.readouterr().out.count("line 5") == 1
