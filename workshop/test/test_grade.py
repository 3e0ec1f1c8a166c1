"""./workshop/grade: students do not affect each other, and no student's folder changes."""

import contextlib
import csv
import html
import json
import os
import re
import signal
import subprocess
import threading
import time
from dataclasses import replace
from types import SimpleNamespace

import psutil
import pytest

from sdc_common.processes import matching
from sdc_experiments.closed_loop import drive_result
from sdc_sim.report.writer import write_report
from sdc_testing.chromium import check_page, headless_chromium
from sdc_workshop.exam import sandbox
from sdc_workshop.exam.answer import Answer, encodable
from sdc_workshop.grading import grade as command
from sdc_workshop.grading.grade import line
from sdc_workshop.grading.grading import Conditions, Grade, grade
from sdc_workshop.grading.handed_in import HandedInError, copy_workspace, names, submissions
from sdc_workshop.grading.record import Record, read
from sdc_workshop.grading.rubric import load_rubric
from sdc_workshop.grading.summary import ranked, write_csv, write_pages
from sdc_workshop.steps import find_step, load_steps
from sdc_workshop.workspace import PROJECT, make, solve, write

pytestmark = pytest.mark.slow(100)

LIMIT_S = 900
# Columns of grades.csv that grades.html shows after the name.
SHOWN = (
    *("mark", "steps_done", "next_step", "driving_score", "unknown_driving_score"),
    *("championship", "status"),
    *("route_completion_percent", "duration_s", "time_ratio", "cross_track_rms_m"),
    *("cross_track_max_m", "lateral_acceleration_max_mps2", "jerk_max_mps3", "comfortable"),
)
# A student's program that does not end. Another run of the tests on this machine has another one.
ENDLESS = f"sleep 98766.{os.getpid()}"


def workspace(folder, *steps):
    make(folder)
    for step_id in steps:
        solve(folder, find_step(step_id))
    return folder


def state(folder):
    """Return names, times, permissions and contents of all files."""
    found = {}
    for path in [folder, *sorted(folder.rglob("*"))]:
        entry = path.lstat()
        content = path.read_bytes() if path.is_file() and not path.is_symlink() else b""
        found[str(path)] = (entry.st_mtime_ns, entry.st_ctime_ns, entry.st_mode, content)
    return found


def left_over(mark):
    """Return the running processes whose command line contains a word."""
    return matching(psutil.process_iter(), lambda one: mark in " ".join(one.cmdline()))


def trace(folder):
    """Return a drive without its reasons of speed: no node outside of the sandbox has them."""
    with (folder / "report.csv").open(encoding="utf-8") as file:
        return [{**row, "reason": ""} for row in csv.DictReader(file)]


def test_each_student_is_graded_alone(tmp_path, sandboxed):
    students = tmp_path / "class"
    solved = workspace(students / "ada", *(step.id for step in load_steps()))
    bert = workspace(students / "bert", "hello", "messages-1")
    write(bert, find_step("camera-2"), "        raise ValueError\n")
    before = state(students)
    output = tmp_path / "grades"
    done = subprocess.run(
        [PROJECT / "workshop" / "grade", students, tmp_path / "missing", "--output", output],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        timeout=LIMIT_S,
    )
    assert state(students) == before, "a student's folder was changed"
    assert left_over(str(solved)) == []
    rows = {
        row["student"]: row
        for row in csv.DictReader((output / "grades.csv").open(encoding="utf-8"))
    }
    assert list(rows)[0] == "ada", done.stdout

    open_steps = {
        name: value
        for name, value in rows["ada"].items()
        if name.startswith("step ") and value != "passed"
    }
    assert open_steps == {}, json.loads((output / "ada" / "answers.json").read_text())
    scores = [rows["ada"][name] for name in ("driving_score", "unknown_driving_score", "mark")]
    assert (rows["ada"]["status"], *scores) == ("completed", "100.0", "100.0", "100.00")
    assert (rows["ada"]["steps_done"], rows["ada"]["note"]) == (str(len(load_steps())), "")
    assert (output / "ada" / "report.png").is_file()

    assert rows["bert"]["step hello"] == rows["bert"]["step messages-1"] == "passed"
    assert rows["bert"]["step camera-2"] == "wrong"
    assert rows["bert"]["step camera-3"] == "unfinished"
    assert (rows["bert"]["next_step"], rows["bert"]["note"]) == ("camera-2", "")

    assert "is no workspace" in rows["missing"]["note"]
    assert done.returncode == 1

    page = (output / "grades.html").read_text(encoding="utf-8")
    words = ("ada", "bert", "missing", "camera-2", "<title>")
    assert [word for word in words if word not in page] == []
    page = (output / "ada" / "page.html").read_text(encoding="utf-8")
    assert "data:image/png;base64," in page and page.count("<iframe") == 2

    write_report(str(tmp_path / "process" / "report.json"), drive_result())
    assert trace(tmp_path / "process") == trace(output / "ada"), "the sandbox changes the drive"
    process, graded = (
        json.loads((folder / "report.json").read_text())
        for folder in (tmp_path / "process", output / "ada")
    )
    assert process == {**graded, "wall_duration_s": None, "real_time_factor": None}


def test_time_limit_names_the_step_and_keeps_the_answers_before_it(world, tmp_path, sandboxed):
    folder = workspace(tmp_path / "slow", "messages-1", "messages-3")
    path = folder / "src/sdc_package/CMakeLists.txt"
    path.write_text(f"execute_process(COMMAND {ENDLESS})\n" + path.read_text())
    conditions = Conditions(30.0, 20000, steps=("messages-1", "messages-3", "messages-7"))
    found = grade("slow", folder, tmp_path / "result", conditions)
    assert found.note == (
        "the build took longer than its time limit and was ended; "
        "the check took longer than its time limit and was ended at messages-3"
    )
    assert {step: answer["status"] for step, answer in found.answers.items()} == {
        "messages-1": "passed"
    }
    assert left_over(ENDLESS) == []


def test_grade_is_kept_until_the_work_changes_and_an_interrupted_one_is_not(world, tmp_path):
    folder, result = workspace(tmp_path / "ada", "messages-1"), tmp_path / "result"
    conditions = Conditions(300.0, steps=("messages-1",), seed=1)
    stopped = grade("ada", folder, result, replace(conditions, stopped=lambda: True))
    assert stopped.note == "the check was interrupted"
    first = grade("ada", folder, result, conditions)
    assert (first.steps_done, first.note) == (1, "")
    (result / "answers.json").unlink()
    assert grade("ada", folder, result, conditions) == first
    assert not (result / "answers.json").exists(), "graded twice"
    assert grade("ada", folder, result, replace(conditions, seed=2)).steps_done == 1
    assert (result / "answers.json").exists(), "the grade of another seed was kept"
    write(folder, find_step("messages-1"), "float32 throttle\n")
    assert grade("ada", folder, result, conditions).steps_done == 0


@pytest.mark.parametrize(
    "options",
    [
        pytest.param(["--no-sandbox"], id="no_sandbox", marks=pytest.mark.nightly),
        pytest.param([], id="sandbox"),
    ],
)
def test_ctrl_c_ends_all_programs(world, tmp_path, options, request):
    if not options:
        request.getfixturevalue("sandboxed")
    folder = workspace(tmp_path / "slow")
    (folder / "src/sdc_package/CMakeLists.txt").write_text(
        f"cmake_minimum_required(VERSION 3.5)\nexecute_process(COMMAND {ENDLESS})\n"
    )
    process = subprocess.Popen(
        [PROJECT / "workshop" / "grade", folder, "--output", tmp_path / "grades", *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    limit = time.monotonic() + LIMIT_S
    while not left_over(ENDLESS):
        assert time.monotonic() < limit and process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=LIMIT_S)
    assert (process.returncode, output) == (130, "")
    assert left_over(ENDLESS) == []


def test_copy_leaves_out_pipes_cycles_and_builds(tmp_path):
    folder = workspace(tmp_path / "ws")
    package = folder / "src" / "sdc_package"
    os.mkfifo(package / "pipe")
    (package / "round").symlink_to(package)
    (package / "nowhere").symlink_to("/does/not/exist")
    (package / "build").mkdir()
    outside = tmp_path / "another_student"
    outside.mkdir()
    (outside / "solution.py").write_text("print()\n")
    (package / "folder").symlink_to(outside)
    (package / "file.py").symlink_to(outside / "solution.py")
    left_out = copy_workspace(folder, tmp_path / "copy")
    assert set(left_out) == {
        str(package / name) for name in ("folder", "file.py", "nowhere", "round")
    }
    copied = tmp_path / "copy" / "src" / "sdc_package"
    camera = "scripts/camera.py"
    assert (copied / camera).read_bytes() == (package / camera).read_bytes()
    assert not any(
        (copied / name).exists() for name in ("pipe", "nowhere", "build", "round/scripts")
    )
    (tmp_path / "thief" / "src").mkdir(parents=True)
    (tmp_path / "thief" / "src" / "sdc_package").symlink_to(package)
    with pytest.raises(HandedInError, match="is a link to another place"):
        copy_workspace(tmp_path / "thief", tmp_path / "third")


def test_missing_sandbox_is_reported_in_one_line_with_the_option(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("PATH", str(tmp_path))
    folder = workspace(tmp_path / "ws")
    arguments = [str(folder), "--output", str(tmp_path / "grades")]
    assert command.main(arguments) == 2
    (tmp_path / "bwrap").write_text("#!/bin/sh\necho 'bwrap: No permissions' >&2\nexit 1\n")
    (tmp_path / "bwrap").chmod(0o755)
    monkeypatch.setattr(sandbox.os, "geteuid", lambda: 1000)
    assert command.main(arguments) == 2
    first, second = capsys.readouterr().err.splitlines()
    assert "bwrap is not installed (apt-get install bubblewrap); --no-sandbox grades" in first
    assert "the kernel forbids it (bwrap: No permissions); --no-sandbox grades" in second
    assert not (tmp_path / "grades" / "grades.csv").exists()


def test_students_are_named_by_the_parts_of_their_paths_that_differ(tmp_path):
    for name in ("a/ws", "b/ws", "b/c"):
        (tmp_path / name / "src" / "sdc_package").mkdir(parents=True)
    paths = [tmp_path / "a" / "ws", tmp_path / "b", tmp_path / "b" / "ws", tmp_path / "none"]
    found = submissions(paths, tmp_path / "grades")
    assert found == [
        tmp_path / "a" / "ws",
        tmp_path / "b" / "c",
        tmp_path / "b" / "ws",
        tmp_path / "none",
    ]
    assert list(names(found).values()) == ["a_ws", "c", "b_ws", "none"]


def test_summary_in_a_students_folder_is_refused(tmp_path, capsys):
    folder = workspace(tmp_path / "ws")
    assert command.main([str(folder), "--output", str(folder / "grades")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "a student's folder" in error


def test_only_steps_that_passed_count_as_done(tmp_path):
    statuses = dict(zip((step.id for step in load_steps()), ("passed", "unfinished", "waiting")))
    answers = {name: {"status": status} for name, status in statuses.items()}
    found = Grade("eve", tmp_path, {**answers, "drive": {"status": "wrong"}}, {})
    assert found.steps_done == 1
    assert found.first_open == "drive"
    assert line(found, len(load_steps())).startswith(f"grade: eve: 1 of {len(load_steps())} steps")
    write_csv(tmp_path / "grades.csv", ranked([found], load_rubric()))
    (row,) = csv.DictReader((tmp_path / "grades.csv").open(encoding="utf-8"))
    assert (row["steps_done"], row["steps"]) == ("1", str(len(load_steps())))
    assert {row[f"step {name}"] for name, status in statuses.items() if status != "passed"} == {
        "unfinished",
        "waiting",
    }


@pytest.mark.slow(8)
def test_equal_results_share_a_rank_and_page_and_table_have_the_same_texts(tmp_path):
    def graded(name, answered, **report):
        texts = dict.fromkeys(("seen", "hint"), "")
        answer = {"status": answered, "expected": "<a & b>", **texts, "file": None, "line": None}
        (tmp_path / name.replace("/", "_")).mkdir()
        report = {"status": "completed", **report} if report else {}
        return Grade(name.replace("/", "_"), tmp_path, {"hello": answer}, report)

    drive = {"driving_score": 80.0, "cross_track_rms_m": 0.12345, "infractions": {"stop": 3}}
    slow = graded("slow", "passed", time_ratio=2.0, comfortable=True, **drive)
    quick, same = (graded(name, "passed", time_ratio=1.1, **drive) for name in ("quick", "same"))
    lost = graded("lost", "wrong", **{**drive, "status": "off_route", "comfortable": True})
    never = graded("<b>never</b>", "wrong")
    rows = ranked([never, slow, same, lost, quick], load_rubric())
    assert [(row.rank, row.grade) for row in rows] == [
        *[(1, quick), (1, same), (3, slow), (4, lost), (5, never)]
    ]
    write_csv(tmp_path / "grades.csv", rows)
    table = list(csv.DictReader((tmp_path / "grades.csv").open(encoding="utf-8")))
    assert [row["infractions_stop"] for row in table] == ["3", "3", "3", "3", ""]
    assert [row["comfortable"] for row in table] == ["", "", "yes", "", ""]
    write_pages(tmp_path, rows, [])
    page = (tmp_path / "grades.html").read_text(encoding="utf-8")
    assert "<b>never" not in page and "&lt;b&gt;never" in page
    for row, found in zip(table, rows):
        shown = page.split(f"{html.escape(found.grade.name)}</a>")[1].split("</tr>")[0]
        cells = [text for text in re.findall(r"<td[^>]*>([^<]*)</td>", shown)]
        assert cells == [row[name] for name in SHOWN]
        own = (tmp_path / found.grade.name / "page.html").read_text(encoding="utf-8")
        assert f"{row['mark']} points" in own
        assert ("&lt;a &amp; b&gt;" in own) == (row["step hello"] == "wrong")
    with headless_chromium() as browser:
        for name in ("grades.html", "quick/page.html", "lost/page.html"):
            check_page(browser, (tmp_path / name).as_uri())


def test_strange_results_of_one_student_are_one_row_and_the_rest_goes_on(tmp_path, monkeypatch):
    half = {"status": "wrong", "expected": "\ud800", "seen": "", "hint": ""}
    found = {
        "ada": {"report": {"status": "completed", "driving_score": 100.0}},
        "eve": {"report": {"status": ["x"], "driving_score": "many"}},
        "hal": {"report": 7},
        "ivy": {},
        "kim": {"answers": {"hello": {**half, "file": None, "line": None}}},
        "leo": {"contained": ['=HYPERLINK("http://x")', "\ud800"]},
    }

    def graded(name, folder, result, conditions):
        (result / "page.html" if name == "ivy" else result).mkdir(parents=True)
        return Grade(name, folder, **found[name])  # a KeyError for bob

    for name in ("bob", *found):
        (tmp_path / "class" / name).mkdir(parents=True)
    monkeypatch.setattr(command, "grade", graded)
    output = tmp_path / "grades"
    arguments = [str(tmp_path / "class"), "--output", str(output), "--no-sandbox"]
    assert command.main(arguments) == 1
    assert output.stat().st_mode & 0o077 == 0, "other users read the marks"
    rows = csv.DictReader((output / "grades.csv").open(encoding="utf-8"))
    rows = {row["student"]: row for row in rows}
    assert sorted(rows) == ["ada", "bob", "eve", "hal", "ivy", "kim", "leo"]
    assert (rows["ada"]["driving_score"], rows["ada"]["note"]) == ("100.0", "")
    assert rows["bob"]["note"].startswith("could not be graded: KeyError")
    assert all(rows[name]["note"].startswith("the results cannot be") for name in ("eve", "hal"))
    assert rows["ivy"]["note"].startswith("no page: IsADirectoryError")
    assert rows["leo"]["contained"].startswith("'=HYPERLINK")
    assert "=HYPERLINK" in (output / "grades.html").read_text(encoding="utf-8")
    assert all((output / name / "page.html").is_file() for name in ("ada", "kim", "leo"))


def test_students_without_control_groups_have_cores_of_their_own(tmp_path, monkeypatch):
    used, barrier = {}, threading.Barrier(2)

    def graded(name, folder, result, conditions):
        used[name] = os.sched_getaffinity(0)
        barrier.wait(LIMIT_S)
        return Grade(name, folder)

    cores = os.sched_getaffinity(0)
    if len(cores) < 2:
        pytest.skip("this machine has one core")
    monkeypatch.setattr(command, "grade", graded)
    monkeypatch.setattr(command, "require", lambda: None)
    monkeypatch.setattr(command, "control_groups", lambda: contextlib.nullcontext((None, None)))
    jobs = [(name, tmp_path / name, Conditions(LIMIT_S, 20000)) for name in ("ada", "eve")]
    options = SimpleNamespace(no_sandbox=False, jobs=None, lab="")
    assert len([*command.grade_here(jobs, tmp_path, options)]) == 2
    assert used["ada"].isdisjoint(used["eve"]) and used["ada"] | used["eve"] == cores
    assert os.sched_getaffinity(0) == cores


def test_evidence_is_not_flooded_away_by_paths_that_a_program_prints(tmp_path):
    record = Record(tmp_path)
    for step in ("hello", "camera-1"):
        record.begin(step)
        for number in range(60):
            record.contained(f"/x{number} is missing", f"/x{number}")
        record.contained("processes of others were killed")
    kills = [event for event in read(tmp_path)[1]["contained"] if not event[2]]
    assert [step for step, *_ in kills] == ["hello", "camera-1"]


def test_result_with_half_a_character_is_an_answer_that_a_page_can_show():
    answer = encodable(Answer("wrong", "a", "\ud800", "ü"))
    assert (answer.seen, answer.hint) == ("\\ud800", "ü")


def test_championship_adds_the_score_of_the_driver_of_each_folder(tmp_path, monkeypatch):
    def hold(arguments, **_):
        folder = arguments[2]
        drivers = {"Bob_Smith.py", "ada.py", "index_.py"}
        assert {path.name for path in folder.glob("*.py")} == drivers
        assert arguments[1:] == ["round", folder, "drives:=7", "reveal:=false", "baselines:=false"]
        (folder / "results").mkdir()
        result = {"score": 81.26, "problems": ["refused: os.fork"]}
        (folder / "results" / "ada.json").write_text(json.dumps(result))

    names = ("ada", "bob", "Bob Smith", "index", "eve")
    for name in names:
        (tmp_path / name).mkdir()
    (tmp_path / "Bob Smith" / "sdc_ws").mkdir()
    for place in ("ada", "Bob Smith/sdc_ws", "index"):
        (tmp_path / place / "driver.py").write_text("class Driver: pass\n")
    (tmp_path / "eve" / "driver.py").symlink_to("../ada/driver.py")
    monkeypatch.setattr(command.subprocess, "run", hold)
    grades = [Grade(name, tmp_path / name) for name in names]
    command.add_championship(grades, tmp_path, 7)
    assert [one.championship for one in grades] == ["81.3", "", "", "", ""]
    assert grades[0].contained == ["refused: os.fork"]
    assert [one.note for one in grades[2:4]] == 2 * ["the championship has no result"]
    assert [grades[4].note, *grades[4].contained] == [
        "",
        f"the link {tmp_path}/eve/driver.py is not followed",
    ]


def test_rubric_that_weighs_a_car_of_ones_own_needs_a_round(tmp_path, capsys):
    rubric, ada = tmp_path / "rubric.yaml", tmp_path / "ada"
    rubric.write_text("weights: {my_car: 1}")
    ada.mkdir()
    options = ["--rubric", str(rubric), "--output", str(tmp_path / "grades")]
    assert command.main([str(ada), *options]) == 2
    assert "add --championship with a number of drives" in capsys.readouterr().err
