"""The event log of a drive gives the parts of its report that are missing."""

import json
import os
import subprocess
import sys
import threading

import numpy as np
import pytest
from referee_rules import RULES

from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.report.completion import complete_report, is_complete
from sdc_sim.report.trace_file import TraceFile
from sdc_sim.report.writer import ReportError, open_report, write_report

pytestmark = pytest.mark.slow(15)

HERE = os.path.dirname(os.path.abspath(__file__))
SCRIPT = os.path.join(HERE, "..", "scripts", "report.py")
TICK_NS = 50_000_000
PARTS = ["report.csv", "report.html", "report.json", "report.png"]


@pytest.fixture
def path(tmp_path):
    return str(tmp_path / "report.json")


def driven(path, ticks=100, trace=None):
    """Return the evaluator of a drive, and its event log."""
    event_log = open_report(path, "drive")
    evaluator = Evaluator(RULES, event_log, trace)
    evaluator.set_route(np.column_stack([np.arange(11.0), np.zeros(11)]))
    for tick in range(1, ticks + 1):
        evaluator.add_odometry(tick * TICK_NS, tick * 0.1, 0.1, 0.0, 2.0 if tick < 100 else 0.0)
        evaluator.add_command(tick * TICK_NS, 0.5, 0.0, -0.25)
    evaluator.add_snapshot(1.0, 20.0, b"a picture")
    return evaluator, event_log


def test_report_of_a_killed_referee_is_made_up(path, tmp_path):
    driven(path, ticks=60, trace=TraceFile(str(tmp_path / "report.csv")))
    done = subprocess.run(
        [SCRIPT, str(tmp_path)], capture_output=True, text=True, timeout=120.0, check=False
    )
    assert done.returncode == 0, done.stderr
    assert sorted(os.listdir(tmp_path)) == PARTS
    report = json.loads((tmp_path / "report.json").read_text())
    assert (report["status"], report["ticks"], report["ticks_by_stamp"]) == ("aborted", 60, 60)
    assert report["assumed_limits"] == list(RULES.planner)
    assert len((tmp_path / "report.csv").read_text().splitlines()) == 61
    assert "data:image/jpeg" in (tmp_path / "report.html").read_text()
    again = subprocess.run(
        [SCRIPT, str(tmp_path)], capture_output=True, text=True, timeout=120.0, check=False
    )
    assert (again.returncode, "nothing is missing" in again.stdout) == (0, True)


def test_metrics_that_are_there_stay(path, tmp_path):
    evaluator, event_log = driven(path)
    result = evaluator.result()
    result.metrics["wall_duration_s"] = 1.5
    write_report(path, result)
    event_log.close()
    before = (tmp_path / "report.json").read_text()
    assert complete_report(path)
    assert (tmp_path / "report.json").read_text() == before
    assert sorted(os.listdir(tmp_path)) == PARTS
    assert "1.500" in (tmp_path / "report.html").read_text()


def test_completion_waits_for_the_drive_and_outlives_its_session(path, tmp_path):
    evaluator, event_log = driven(path)
    start = f"from sdc_sim.report.completion import start_completion; start_completion({path!r})"
    subprocess.run([sys.executable, "-c", start], check=True, timeout=60.0, start_new_session=True)
    write_report(path, evaluator.result())
    assert not (tmp_path / "report.html").exists()
    event_log.close()
    assert not complete_report(path) or is_complete(path)
    assert sorted(os.listdir(tmp_path)) == PARTS


def test_second_completion_waits_and_finds_nothing_to_do(path, tmp_path):
    evaluator, event_log = driven(path)
    write_report(path, evaluator.result())
    wrote = []
    threads = [
        threading.Thread(target=lambda: wrote.append(complete_report(path))) for _ in range(2)
    ]
    for thread in threads:
        thread.start()
    event_log.close()
    for thread in threads:
        thread.join()
    assert sorted(wrote) == [False, True]


def test_next_drive_does_not_wait_and_keeps_its_own_log(path, tmp_path):
    evaluator, event_log = driven(path)
    new_log = open_report(path, "next")
    new_log.append(["command", 1])
    event_log.remove()
    assert list(new_log.events()) == [["command", 1]]
    assert os.listdir(tmp_path) == ["report.journal"]


@pytest.mark.parametrize(
    ("prepare", "message"),
    [
        (lambda path: None, "No such file"),
        (lambda path: open_report(path, "drive").close(), "the drive has no route"),
        (lambda path: _write(path, b"nonsense"), "is not an event log"),
    ],
)
def test_report_without_a_usable_event_log_is_refused_in_one_line(path, tmp_path, prepare, message):
    prepare(path)
    done = subprocess.run(
        [SCRIPT, str(tmp_path)], capture_output=True, text=True, timeout=60.0, check=False
    )
    assert done.returncode == 1
    assert message in done.stderr
    assert "report.journal" in done.stderr
    assert done.stderr.count("\n") == 1


def _write(path, data):
    with open(path.replace(".json", ".journal"), "wb") as file:
        file.write(data)


def test_error_of_a_page_is_reported(path, tmp_path):
    driven(path)
    (tmp_path / "report.png").mkdir()
    with pytest.raises(ReportError, match="the pages are not"):
        complete_report(path)
    assert not is_complete(path), "the next call can complete it"
