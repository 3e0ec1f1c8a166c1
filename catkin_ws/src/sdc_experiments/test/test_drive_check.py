"""The integration check that other teams run, and the report of a drive that loses its world."""

import json
import os
import signal

import pytest

from sdc_common.processes import isolated_ros_environment, wait_until
from sdc_experiments.closed_loop import drive_result
from sdc_sim.report.writer import write_report
from sdc_sim.runner import isolated_drive
from sdc_sim.scenario.acceptance_limits import read_report
from sdc_testing.program import Program, run

pytestmark = pytest.mark.slow(12)

HERE = os.path.dirname(os.path.abspath(__file__))
STACKS = os.path.join(HERE, "stacks")
DRIVE = os.path.abspath(os.path.join(HERE, "..", "..", "..", "..", "drive"))
OTHER_NODES = "sim.py", "mission_planner.py"


@pytest.fixture
def environment(tmp_path):
    with isolated_ros_environment(tmp_path / "ros") as variables:
        yield variables


def check(environment, folder, *arguments):
    """Run drive.test as a team's CI does; return its exit status and output."""
    command = ["rostest", "--results-base-dir", str(folder), "sdc_sim", "drive.test"]
    command += ["report:=found/report.json", *arguments]
    done = run(*command, folder=folder, environment=environment)
    return done.returncode, done.stdout


def test_stack_off_its_lane_fails_with_the_metrics_and_leaves_a_report(environment, tmp_path):
    stack = os.path.join(STACKS, "left_of_the_lane.launch")
    given = "scenario:=lane_change", f"stack:={stack}", "max_cross_track_m:=0.5"
    status, output = check(environment, tmp_path, *given)
    assert status != 0
    report = json.loads((tmp_path / "found" / "report.json").read_text())
    assert report["status"] == "completed"
    assert 0.7 < report["cross_track_max_m"] < 1.0
    worst = f"{report['cross_track_max_m']:.4g}"
    assert f"cross_track_max_m is {worst}, at most 0.5 is allowed" in output
    assert "cross_track_rms_m" in output
    assert "missed_ticks" not in output, "only violations are reported"


@pytest.mark.nightly
def test_stack_that_ignores_lights_fails():
    stack = os.path.join(STACKS, "blind_to_lights.launch")
    with isolated_drive("traffic_lights", {"stack": stack}) as (drive, lines):
        assert "infractions is 1, at most 0 is allowed" in lines
        assert read_report(drive.report_path)[0]["infractions"]["red_light"] == 1


def test_stack_that_cannot_be_launched_fails_with_the_end_of_its_log(tmp_path):
    stack = tmp_path / "broken.launch"
    stack.write_text("<launch>\n  <include file='nowhere.launch'/>\n</launch>\n")
    with isolated_drive("oval", {"stack": str(stack)}) as (_, (first, *_, last)):
        assert "wrote no report" in first
        assert "nowhere.launch" in last


@pytest.mark.parametrize(
    "node",
    ["referee.py", *(pytest.param(one, marks=pytest.mark.nightly) for one in OTHER_NODES)],
)
def test_death_of_the_world_ends_the_drive_with_a_report_until_then(environment, tmp_path, node):
    """The trace begins as that of an undisturbed drive, bit for bit."""
    options = ["headless:=true", "sync:=true", "camera:=false"]
    command = [DRIVE, *options, "referee_options:={pictures: false}"]
    drive = Program(command, environment, tmp_path, tmp_path / "log")
    events = tmp_path / "report" / "report.events.jsonl"
    has_begun = lambda: events.exists() and events.read_bytes().count(b"\n") > 400  # noqa: E731
    wait_until(has_begun, 120.0, "400 events of the drive")
    os.kill(drive.pid_of(node), signal.SIGKILL)
    assert drive.wait_for_end() == 1, drive.output[-3000:]
    report = json.loads((tmp_path / "report" / "report.json").read_text())
    assert (report["status"], report["world_restarts"]) == ("aborted", 0)
    write_report(str(tmp_path / "process.json"), drive_result())
    trace = (tmp_path / "report" / "report.csv").read_text().splitlines()
    assert len(trace) == 1 + report["ticks"] > 50
    undisturbed = (tmp_path / "process.csv").read_text().splitlines()[: len(trace)]
    # A killed referee may have received the odometry of some ticks, and not yet their commands.
    assert trace[:-20] == undisturbed[:-20]
    poses = [[row.split(",")[:8] for row in rows] for rows in (trace, undisturbed)]
    assert poses[0] == poses[1]
