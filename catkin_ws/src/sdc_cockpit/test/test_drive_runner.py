"""Drives that a page starts, with a short program in the place of ./drive."""

import os
import signal
import subprocess
import sys
import threading
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from sdc_cockpit.drive_runner import DriveRunner
from sdc_common.processes import wait_until

# Waits for a signal, or ends at once, and writes a report as ./drive does.
PROGRAM = f"""#!{sys.executable}
import json, os, signal, sys
report = [word for word in sys.argv if word.startswith("report:=")][0][len("report:="):]
print("arguments", sys.argv[1:], flush=True)
def write(status):
    with open(report, "w") as file:
        json.dump({{"status": status, "driving_score": 87.5}}, file)
    with open(report.replace("json", "html"), "w") as file:
        file.write("<h1>report</h1>")
def end(*_):
    write("aborted")
    sys.exit(130)
signal.signal(signal.SIGTERM, end)
if "sync:=true" in sys.argv:
    write("completed")
    sys.exit(0)
if "seed:=1" in sys.argv:
    print(report + ": ticks is 4", report + ": stops is 2", "drive: failed", sep="\\n")
    write("completed")
    sys.exit(1)
if "map:=gone" in sys.argv:
    print("\x1b[31mdrive: there is no map gone\x1b[0m")
    sys.exit(2)
print("prepare: compiling: 36 %", flush=True)
open(os.path.join(os.path.dirname(report), "ready"), "w").close()
while True:
    signal.pause()
"""


@pytest.fixture
def runner(tmp_path):
    program = tmp_path / "drive"
    program.write_text(PROGRAM)
    program.chmod(0o755)
    ended = threading.Semaphore(0)
    runner = DriveRunner(str(program), tmp_path / "drives", ended.release)
    runner.ended = lambda: ended.acquire(timeout=60.0)
    yield runner
    runner.end()


def test_drive_that_ends_is_listed_with_its_report(runner):
    name = runner.start("oval", ["scenario:=oval", "sync:=true"])
    assert name.endswith("-oval")
    assert runner.ended()
    assert runner.running is None
    (row,) = runner.past()
    assert (row["name"], row["status"], row["exit_status"]) == (name, "completed", 0)
    assert (row["driving_score"], row["page"]) == (87.5, True)
    assert row["arguments"] == ["scenario:=oval", "sync:=true"]
    log = runner.file(name, "drive.log").read_text()
    assert "headless:=true" in log and "cockpit:=false" in log
    assert runner.file(name, "report.html").read_text() == "<h1>report</h1>"


def test_one_drive_runs_at_a_time_and_a_stop_ends_it(runner, tmp_path):
    name = runner.start("", [])
    wait_until((tmp_path / "drives" / name / "ready").exists, 60.0, "the start")
    with pytest.raises(ValueError, match=f"the drive {name} runs; stop it first"):
        runner.start("", [])
    assert runner.past() == []
    assert (runner.phase, runner.last) == ("compiling: 36 %", None)
    runner.stop()
    assert runner.ended()
    assert [runner.past()[0][key] for key in ("status", "problem")] == ["aborted", ""]
    assert (runner.phase, runner.last) == ("", name)
    with pytest.raises(ValueError, match="no drive runs"):
        runner.stop()


@pytest.mark.parametrize(
    ("argument", "problem"),
    [("seed:=1", "ticks is 4; stops is 2"), ("map:=gone", "drive: there is no map gone")],
)
def test_drive_that_fails_is_listed_with_its_cause(runner, argument, problem):
    runner.start("", [argument])
    assert runner.ended()
    assert runner.past()[0]["problem"] == problem


def test_no_other_file_is_served(runner):
    name = runner.start("", ["sync:=true"])
    assert runner.ended()
    others = (name, "drive.json"), (name, "../drive"), ("..", "drive"), ("other", "report.html")
    assert [runner.file(*one) for one in others] == [None] * 4
    with pytest.raises(ValueError, match="there is no drive '../x'"):
        runner.comparison(name, "../x")


def test_command_that_starts_drives_is_no_parameter():
    """Any program, and a page in a browser, can set a parameter of the ROS master."""
    launch = ElementTree.parse(Path(__file__).parents[1] / "launch" / "cockpit.launch")
    assert {param.get("name") for param in launch.iter("param")} == {"address", "port"}


def test_drive_with_the_name_of_an_option_is_compared_as_a_drive(runner, tmp_path):
    for name in ("--help", "other"):
        (tmp_path / "drives" / name).mkdir(parents=True)
        (tmp_path / "drives" / name / "drive.json").write_text("{}")
    with pytest.raises(ValueError, match="--help"):
        runner.comparison("--help", "other")


@pytest.mark.parametrize("link", (None, "folder", "report.html", "drive.json", "report.json"))
def test_links_in_the_folder_of_the_drives_are_not_followed(runner, tmp_path, link):
    drive, real = tmp_path / "drives" / "1-oval", tmp_path / "real"
    real.mkdir()
    drive.parent.mkdir()
    for name in ("report.html", "drive.json", "report.json"):
        (real / name).write_text("{}")
    if link == "folder":
        drive.symlink_to(real)
    else:
        drive.mkdir()
        for path in real.iterdir():
            place = drive / path.name
            place.symlink_to(path) if path.name == link else place.write_text("{}")
    assert [row["name"] for row in runner.past()] == (["1-oval"] if link is None else [])
    assert (runner.file("1-oval", "report.html") is None) == (link is not None)


def test_page_of_one_drive_starts_none(tmp_path):
    runner = DriveRunner("", tmp_path, lambda: None)
    assert not runner.offered and runner.past() == []
    with pytest.raises(ValueError, match="./cockpit serves one that starts drives"):
        runner.start("", [])


@pytest.mark.slow(2)
def test_drive_ends_when_its_starter_is_killed(runner, tmp_path):
    code = f"""
import threading
from pathlib import Path
from sdc_cockpit.drive_runner import DriveRunner
folder = Path({str(tmp_path)!r})
runner = DriveRunner(str(folder / "drive"), folder / "drives", print)
print(runner.start("", []), flush=True)
threading.Event().wait()
"""
    starter = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    name = starter.stdout.readline().strip()
    wait_until((tmp_path / "drives" / name / "ready").exists, 60.0, "the start")
    os.kill(starter.pid, signal.SIGKILL)
    starter.wait()
    wait_until((tmp_path / "drives" / name / "report.html").exists, 60.0, "the report")
