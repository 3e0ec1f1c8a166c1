"""Drive every packaged scenario in lockstep with real nodes: ./test scenarios."""

import csv
import os
from pathlib import Path

import pytest

from sdc_common.ros.master_port import free_master_port
from sdc_sim.scenario.runner import CheckedDrive

pytestmark = pytest.mark.slow(60)

FOLDER = os.path.join(
    os.path.dirname(os.path.abspath(__file__)), "..", "..", "sdc_sim", "scenarios"
)
NAMES = sorted(name[: -len(".yaml")] for name in os.listdir(FOLDER) if name.endswith(".yaml"))
# ./test drives these; a nightly run, and ./test scenarios, drive all of them.
ALWAYS = {"town", "slalom", "stopped_car", "traffic_lights", "student_nodes"}
TIMEOUT_S = 300.0
# Every tenth tick of a drive, from the first columns of its report.csv.
TRACES = Path(__file__).with_name("traces")
TOLERANCE = 1e-6


@pytest.fixture
def environment(tmp_path):
    return {
        **os.environ,
        "ROS_MASTER_URI": f"http://127.0.0.1:{free_master_port()}",
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(tmp_path / "ros"),
    }


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=() if name in ALWAYS else pytest.mark.nightly) for name in NAMES],
)
def test_drive_meets_the_limits_of_its_scenario(name, environment, tmp_path):
    drive = CheckedDrive(
        name, str(tmp_path / "report.json"), {"referee_options": "{pictures: false}"}
    )
    lines = drive.run(TIMEOUT_S, environment=environment)
    assert not lines, "\n".join(lines)
    if (TRACES / f"{name}.csv").exists():
        check_trace(TRACES / f"{name}.csv", tmp_path / "report.csv")


def check_trace(stored, driven):
    """Compare a drive with one of another machine, whose libraries may round otherwise."""
    with open(stored, newline="") as expected, open(driven, newline="") as found:
        rows = list(csv.DictReader(found))[9::10]
        for line, row in enumerate(csv.DictReader(expected)):
            for column, value in row.items():
                assert float(rows[line][column]) == pytest.approx(float(value), abs=TOLERANCE), (
                    f"{stored.name}, {column} at {row['time_s']} s"
                )
    assert len(rows) == line + 1
