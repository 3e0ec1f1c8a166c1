"""The command ./drive, with real processes under a ROS master of their own."""

import json
import os
import re
import shutil
import signal
import subprocess

import pytest

from sdc_common.processes import wait_until
from sdc_testing.program import run

pytestmark = pytest.mark.slow(30)

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", "..", ".."))
DRIVE = os.path.join(ROOT, "drive")


def drive(environment, folder, *arguments):
    return run(DRIVE, "headless:=true", *arguments, folder=folder, environment=environment)


def test_lockstep_drive_is_complete_and_replay_gives_the_same_report(environment, bend, tmp_path):
    (tmp_path / "bend.yaml").write_text(
        "route: bend.csv\nlimits:\n  at_most: {cross_track_rms_m: 0.1, cross_track_max_m: 0.3}\n"
    )
    done = drive(
        environment,
        tmp_path,
        "scenario:=bend.yaml",
        "sync:=true",
        "camera:=true",
        "record:=true",
        "report:=found/report.json",
    )
    assert done.returncode == 0, done.stdout
    assert "all limits are met" in done.stdout
    assert f"drive: the report is {tmp_path}/found/report.html" in done.stdout
    assert "Traceback" not in done.stdout
    # A busy machine may warn of what is late.
    loud = "no path|has stopped|process|SUMMARY|\x1b"
    assert not re.search(loud, done.stdout), done.stdout
    assert "process[sim" in (tmp_path / "found" / "report.log").read_text()
    report = json.loads((tmp_path / "found" / "report.json").read_text())
    assert (report["status"], report["missed_ticks"]) == ("completed", 0)
    assert (tmp_path / "found" / "report.png").stat().st_size > 10_000
    pictures = (tmp_path / "found" / "report.html").read_text().count("data:image/jpeg")
    # Snapshots follow the wall clock, so that a fast drive may miss some.
    assert 1 <= pictures <= 6, done.stdout
    trace = (tmp_path / "found" / "report.csv").read_bytes()

    replay = "roslaunch", "sdc_sim", "replay.launch", "bag:=found/report.bag"
    done = run(*replay, folder=tmp_path, environment=environment)
    assert "Traceback" not in done.stdout
    assert (tmp_path / "report" / "replay.csv").read_bytes() == trace
    again = json.loads((tmp_path / "report" / "replay.json").read_text())
    assert again == {**report, "wall_duration_s": None, "real_time_factor": None}, (
        "a replay has no wall time"
    )


def test_bad_route_ends_the_drive_with_one_line(environment, tmp_path):
    (tmp_path / "report").mkdir()
    (tmp_path / "report" / "report.json").write_text('{"status": "completed"}')
    (tmp_path / "bad.csv").write_text("0,0\n1,word\n")
    done = drive(environment, tmp_path, "waypoints_path:=bad.csv")
    assert done.returncode != 0
    assert f"{tmp_path}/bad.csv, row 2: y is 'word'" in done.stdout
    assert len(done.stdout.splitlines()) == 1
    assert not (tmp_path / "report" / "report.json").exists(), "an old report is removed"
    done = drive(environment, tmp_path, "steering_method:=mine:Mine")
    assert re.fullmatch("drive: .* mine.py must be on the PYTHONPATH\n", done.stdout)


@pytest.mark.nightly
def test_report_that_cannot_be_written_ends_the_drive(environment, tmp_path):
    (tmp_path / "file").write_text("")
    done = drive(environment, tmp_path, "sync:=true", "camera:=false", "report:=file/report.json")
    assert done.returncode != 0
    assert "report:=FILE" in done.stdout


def test_node_of_the_car_that_refuses_a_parameter_ends_the_drive(environment, tmp_path):
    done = drive(environment, tmp_path, "camera:=false", "planner_options:={braking_mps2: -3.0}")
    assert done.returncode != 0
    line = "local_planner: config/local_planner.yaml: braking_mps2 must be a positive number"
    assert done.stdout.count(line) == 1


def test_scenario_limits_decide_the_exit_status(environment, tmp_path):
    (tmp_path / "mine.yaml").write_text(
        "route: [straight_m: 40]\nlimits:\n  at_most: {speed_max_mps: 7.0}\n"
    )
    done = drive(
        environment,
        tmp_path,
        "scenario:=mine.yaml",
        "planned_speed_mps:=9",
        "sync:=true",
        "camera:=false",
        "referee_options:={pictures: false}",
    )
    assert done.returncode == 1, done.stdout
    assert "speed_max_mps is " in done.stdout.splitlines()[-3]
    assert "process[sim" in done.stdout, "a drive that fails shows everything"
    assert sorted(name.name for name in tmp_path.iterdir()) == ["mine.yaml", "report", "ros"]


def test_bad_scenario_ends_the_drive_with_one_line(environment, tmp_path):
    """It cannot set a path to write, either; the mistakes of its reader contain the other paths."""
    (tmp_path / "wrong.yaml").write_text(f"route: town\nreport: {tmp_path}/elsewhere/file\n")
    done = drive(environment, tmp_path, "scenario:=wrong.yaml")
    assert done.returncode != 0
    assert re.fullmatch(".*wrong.yaml, line 2: unknown key 'report'.*\n", done.stdout)
    assert not (tmp_path / "elsewhere").exists()


@pytest.mark.nightly
def test_sigterm_ends_all_processes(environment, start, tmp_path):
    """As Ctrl-C does, which test_security.py sends."""
    options = ["headless:=true", "camera:=false", "referee_options:={pictures: false}"]
    started = start([DRIVE, *options], environment)
    started.wait_for_output("cross-track error")
    started.process.send_signal(signal.SIGTERM)
    assert started.wait_for_end() == 130
    assert json.loads((tmp_path / "report" / "report.json").read_text())["status"] == "aborted"


@pytest.mark.nightly
def test_mistake_that_only_a_node_of_a_lab_notices_ends_the_drive(environment, tmp_path):
    # The drive has begun: its report needs no pages.
    options = ["referee_options:={pictures: false}", "perception:=imitation"]
    done = drive(environment, tmp_path, *options)
    assert done.returncode != 0
    assert "network must be an absolute path, got ''" in done.stdout


@pytest.mark.skipif(not shutil.which("xdg-open"), reason="xdg-utils is not installed")
@pytest.mark.nightly
@pytest.mark.parametrize("headless", ["true", "false"])
def test_page_of_a_drive_on_a_screen_is_opened(environment, tmp_path, headless):
    (tmp_path / "route.csv").write_text("".join(f"{x},0\n" for x in range(16)))
    browser = tmp_path / "browser"
    browser.write_text('#!/bin/sh\necho "$1" > "$(dirname "$0")/opened"\n')
    browser.chmod(0o755)
    entry = tmp_path / "applications" / "browser.desktop"
    entry.parent.mkdir()
    entry.write_text(f"[Desktop Entry]\nType=Application\nName=Browser\nExec={browser} %f\n")
    (tmp_path / "mimeapps.list").write_text("[Default Applications]\ntext/html=browser.desktop\n")
    command = f"{DRIVE} headless:={headless} camera:=false waypoints_path:=route.csv cockpit:=false"
    screen = {**environment, "DISPLAY": ":99", "WORKSHOP_URL": ""}
    screen.update(XDG_DATA_HOME=str(tmp_path), XDG_CONFIG_HOME=str(tmp_path))
    done = subprocess.run(
        ["script", "-qec", command, "/dev/null"],
        cwd=tmp_path,
        env=screen,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=200,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert b"\r\x1b[Kreferee: " in done.stdout, "the status line updates in place"
    page = tmp_path / "report" / "report.html"
    opened = tmp_path / "opened"
    if headless == "false":
        wait_until(opened.exists, 30.0, "the browser")
        assert opened.read_text().strip().endswith(str(page))
    else:
        assert page.exists()
        assert not opened.exists()
