"""./workshop/grade --scheduler: a real scheduler and worker grade what they see."""

import csv
import os
import sys

import pytest

from sdc_testing.program import Program, programs
from sdc_workshop.grading import cluster
from sdc_workshop.grading.cluster import worker_problem
from sdc_workshop.grading.grade import main
from sdc_workshop.steps import find_step
from sdc_workshop.workspace import PROJECT, make, solve

LIMIT_S = 300.0
PYTHON = (sys.executable, "-m")


@pytest.fixture
def start(tmp_path):
    with programs(tmp_path, end=Program.kill) as start:
        yield start


@pytest.fixture
def scheduler(start):
    """Return a function that starts a scheduler with a PYTHONPATH and returns its address."""

    def scheduler(python_path):
        program = start(
            *PYTHON, "distributed.cli.dask_scheduler", "--host", "127.0.0.1",
            "--port", "0", "--no-dashboard", "--no-show",
            environment={**os.environ, "PYTHONPATH": python_path},
        )  # fmt: skip
        return program.wait_for_match(r"Scheduler at:\s+(\S+)\s")

    return scheduler


@pytest.mark.nightly
@pytest.mark.slow(20)
def test_worker_of_a_cluster_grades_as_this_machine_does(start, scheduler, tmp_path):
    students = tmp_path / "class"
    make(students / "ada")
    for step in ("messages-1", "messages-3"):
        solve(students / "ada", find_step(step))
    python_path = f"{PROJECT / 'workshop'}:{os.environ['PYTHONPATH']}"
    address = scheduler(python_path)
    start(
        *PYTHON, "distributed.cli.dask_worker", address, "--nthreads", "1",
        "--no-nanny", "--no-dashboard", "--local-directory", tmp_path,
        environment={**os.environ, "PYTHONPATH": python_path},
    )  # fmt: skip
    output = tmp_path / "grades"
    grading = start(
        PROJECT / "workshop" / "grade", students, tmp_path / "missing",
        "--output", output, "--scheduler", address, "--no-sandbox",
    )  # fmt: skip
    assert grading.wait_for_end(LIMIT_S) == 1, grading.output
    with open(output / "grades.csv", encoding="utf-8") as file:
        rows = {row["student"]: row for row in csv.DictReader(file)}
    assert list(rows) == ["ada", "missing"], grading.output
    assert rows["ada"]["note"] == ""
    assert rows["ada"]["step messages-1"] == "passed"
    assert rows["ada"]["step messages-3"] == "passed"
    assert "is no workspace" in rows["missing"]["note"]
    assert (output / "grades.html").is_file()
    assert list(output.glob("*.token")) == []


@pytest.mark.nightly
def test_missing_scheduler_is_named_in_one_line(tmp_path, capsys):
    arguments = [str(tmp_path / "ada"), "--output", str(tmp_path / "grades"), "--no-sandbox"]
    assert main([*arguments, "--scheduler", "tcp://127.0.0.1:1"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("grade: no Dask scheduler at tcp://127.0.0.1:1 (")
    assert error.count("\n") == 1


@pytest.mark.slow(2)
def test_scheduler_without_the_project_is_named_in_one_line(scheduler, tmp_path, capsys):
    arguments = [str(tmp_path / "ada"), "--output", str(tmp_path / "grades"), "--no-sandbox"]
    assert main([*arguments, "--scheduler", scheduler("")]) == 2
    error = capsys.readouterr().err
    assert error.startswith("grade: the scheduler: it cannot load sdc_workshop.grading.cluster (")
    assert error.count("\n") == 1


def test_worker_without_the_shared_folder_is_refused(tmp_path, monkeypatch):
    token = tmp_path / "grading.token"
    monkeypatch.setattr(cluster, "WORLD_SETUP", str(token))  # no test has to build the world first
    problem = worker_problem(str(token), False)
    assert problem.startswith(f"it does not see {tmp_path}; put the workspaces and --output into")
    token.touch()
    assert worker_problem(str(token), False) == ""
