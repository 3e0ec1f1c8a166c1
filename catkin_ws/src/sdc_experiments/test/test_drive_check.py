"""Tests of the integration check that other teams run."""

import csv
import itertools
import json
import os
import subprocess

import pytest

from sdc_common.processes import isolated_ros_environment
from sdc_experiments.closed_loop import drive_result
from sdc_sim.report.writer import write_report
from sdc_sim.runner import isolated_drive
from sdc_sim.scenario.acceptance_limits import read_report

pytestmark = pytest.mark.slow(12)

STACKS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "stacks")
TIMEOUT_S = 300.0


@pytest.fixture
def environment(tmp_path):
    with isolated_ros_environment(tmp_path / "ros") as variables:
        yield variables


def check(environment, folder, *arguments):
    """Run drive.test as a team's CI does; return its exit status and output."""
    done = subprocess.run(
        [
            "rostest",
            "--results-base-dir",
            str(folder),
            "sdc_sim",
            "drive.test",
            "report:=found/report.json",
            *arguments,
        ],
        cwd=folder,
        env={**environment, "PWD": str(folder)},
        timeout=TIMEOUT_S,
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    )
    return done.returncode, done.stdout


def test_stack_off_its_lane_fails_with_the_metrics_and_leaves_a_report(environment, tmp_path):
    stack = os.path.join(STACKS, "left_of_the_lane.launch")
    status, output = check(
        environment, tmp_path, "scenario:=lane_change", f"stack:={stack}", "max_cross_track_m:=0.5"
    )
    assert status != 0
    report = json.loads((tmp_path / "found" / "report.json").read_text())
    assert report["status"] == "completed"
    assert 0.7 < report["cross_track_max_m"] < 1.0
    assert (
        f"cross_track_max_m is {report['cross_track_max_m']:.4g}, at most 0.5 is allowed" in output
    )
    assert "cross_track_rms_m" in output
    assert "missed_ticks" not in output, "only violations are reported"


@pytest.mark.nightly
def test_stack_that_stops_at_lights_passes_and_gives_the_trace_of_one_process(
    environment, tmp_path
):
    status, output = check(environment, tmp_path, "scenario:=traffic_lights", "camera:=false")
    assert status == 0, output
    write_report(str(tmp_path / "process.json"), drive_result("traffic_lights"))
    trace = tmp_path / "found" / "report.csv"
    assert trace.read_bytes() == (tmp_path / "process.csv").read_bytes()
    with open(trace, encoding="utf-8", newline="") as file:
        reasons = [row["reason"] for row in csv.DictReader(file)]
    found = [name for name, _ in itertools.groupby(reasons)]
    assert found[:3] == ["accelerating", "cruise", "traffic_light"]
    assert found[-1] == "end_of_route"
    assert "" not in found, "every tick has a reason"


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
