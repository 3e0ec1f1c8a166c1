"""Drive every packaged scenario with real nodes, and in one process: ./test scenarios.

Both drives are the same, bit for bit.
"""

import csv
import importlib.util
import json
import os
from pathlib import Path

import pytest

from sdc_experiments.closed_loop import drive_result
from sdc_sim.report.writer import write_report
from sdc_sim.runner import isolated_drive
from sdc_sim.scenario.acceptance_limits import read_report, violations
from sdc_sim.scenario.packaged import folder_of
from sdc_sim.scenario.reader import load_scenario

pytestmark = pytest.mark.slow(20)

FOLDER = folder_of("scenario")
NAMES = sorted(name[: -len(".yaml")] for name in os.listdir(FOLDER) if name.endswith(".yaml"))
# ./test drives this one with real nodes; a nightly run, and ./test scenarios, drive all of them.
# Real nodes also drive the town in test_grade.py and a lane change in test_drive_check.py.
ALWAYS = {"stopped_car"}
TIMEOUT_S = 300.0
# Their traffic takes longer than all other drives together; test_map_drives.py drives in traffic.
RARE = {"town_motorway_traffic", "town_pedestrians", "town_traffic"}
NIGHTLY = [], [pytest.mark.nightly]
# Every tenth tick of a drive, from the first columns of its report.csv.
TRACES = Path(__file__).with_name("traces")
TOLERANCE = 1e-6
# Only a drive of nodes has a wall clock.
WALL_CLOCK = {"wall_duration_s": None, "real_time_factor": None}


def on_map(name):
    """Return the mark that skips a scenario on a map where nothing reads maps."""
    missing = importlib.util.find_spec("sumolib") is None
    return [pytest.mark.skipif(missing and name.startswith("town_"), reason="no sumolib")]


@pytest.mark.parametrize(
    "name",
    [pytest.param(one, marks=on_map(one) + NIGHTLY[one not in ALWAYS]) for one in NAMES],
)
def test_drive_meets_the_limits_of_its_scenario(name):
    with isolated_drive(name, {}, timeout_s=TIMEOUT_S) as (drive, lines):
        assert not lines, "\n".join(lines)
        folder = Path(drive.report_path).parent
        check_trace(name, folder / "report.csv")
        check_drive_in_process(name, folder)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(one, marks=on_map(one) + NIGHTLY[one in RARE])
        for one in NAMES
        if one not in ALWAYS
    ],
)
def test_drive_in_process_meets_the_limits_of_its_scenario(name, tmp_path):
    write_report(str(tmp_path / "report.json"), drive_result(name))
    limits = load_scenario(os.path.join(FOLDER, name + ".yaml")).limits
    assert violations(limits, *read_report(str(tmp_path / "report.json"))) == []
    check_trace(name, tmp_path / "report.csv")


def check_drive_in_process(name, folder):
    """Compare every number of the drive with that of the same scenario in one process."""
    write_report(str(folder / "process.json"), drive_result(name))
    assert (folder / "process.csv").read_text() == (folder / "report.csv").read_text()
    files = "report.json", "process.json"
    report, process = (json.loads((folder / file).read_text()) for file in files)
    assert process == {**report, **WALL_CLOCK}
    assert list(process) == list(report)


def check_trace(name, driven):
    """Compare a drive with one of another machine, whose libraries may round otherwise."""
    stored = TRACES / f"{name}.csv"
    if not stored.exists():
        return
    with open(stored, newline="") as expected, open(driven, newline="") as found:
        rows = list(csv.DictReader(found))[9::10]
        for line, row in enumerate(csv.DictReader(expected)):
            for column, value in row.items():
                assert float(rows[line][column]) == pytest.approx(float(value), abs=TOLERANCE), (
                    f"{stored.name}, {column} at {row['time_s']} s"
                )
    assert len(rows) == line + 1
