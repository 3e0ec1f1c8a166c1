"""Each mistake fails its step, with a sentence that names it; unusual code that is right passes."""

import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from finished_workspace import solved
from judge_mistakes import table

from sdc_workshop.steps import all_steps, hint_of
from sdc_workshop.workspace import PROJECT

PARTS = 20
LIMIT_S = 3000


def test_each_step_has_wrong_and_right_solutions_and_a_hint():
    rows = table()
    count = Counter((row["step"], row["says"] == "right") for row in rows)
    for step in filter(lambda step: step.file, all_steps()):
        wrong, right = (5, 2) if step.file.endswith(".py") else (2, 0)
        assert count[step.id, False] >= wrong and count[step.id, True] >= right, step.id
    assert all(hint_of(step.id).hint and hint_of(step.id).more for step in all_steps())
    assert len({(row["step"], row["name"]) for row in rows}) == len(rows)


@pytest.fixture(scope="module")
def workspace(tmp_path_factory):
    return solved(tmp_path_factory.mktemp("student") / "ws")


@pytest.mark.mistakes
@pytest.mark.slow(40)
@pytest.mark.nightly
@pytest.mark.parametrize("part", range(PARTS))
def test_mistakes_are_explained_and_unusual_code_passes(part, workspace, record_property):
    judge(workspace, record_property, str(part), str(PARTS))


def changed_steps(since):
    """Return the steps whose solution, or whose rows of mistakes, differ from those of a commit."""
    command = ["git", "-C", str(PROJECT), "diff", "--unified=0", since, "--"]
    folders = ["workshop/test", "catkin_ws/src"]
    lines = subprocess.check_output([*command, *folders], text=True).splitlines()
    files = {line[6:] for line in lines if line.startswith("+++ b/")}
    rows = {line[10:].split(",")[0] for line in lines if line.startswith("+- {step: ")}
    # A lab is in a folder of its own.
    solutions = {file.replace("/labs/", "/") for file in files}
    return sorted(
        step.id
        for step in all_steps()
        if step.id in rows or f"catkin_ws/src/{step.file}" in solutions
    )


@pytest.mark.skipif("CHANGED_SINCE" not in os.environ, reason=".ci/run sets it")
@pytest.mark.slow(40)
def test_mistakes_of_changed_steps(workspace, record_property):
    steps = changed_steps(os.environ["CHANGED_SINCE"])
    if steps:
        judge(workspace, record_property, "0", "1", *steps)


@pytest.mark.slow(40)
def test_no_drive_of_a_lab_believes_the_process_of_the_student(workspace, record_property):
    judge(workspace, record_property, "0", "1", "the referee is patched", "the score is patched")


def judge(workspace, record_property, *which):
    devel = next(Path(PROJECT).glob("catkin_ws/devel/lib/python3*/dist-packages"))
    path = [str(PROJECT / "workshop"), str(devel), os.environ.get("PYTHONPATH", "")]
    program = Path(__file__).with_name("judge_mistakes.py")
    done = subprocess.run(
        [sys.executable, "-B", program, workspace, *which],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(path)},
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    record_property("judged rightly", done.stdout.splitlines()[-1:])
    assert done.returncode == 0, done.stdout + done.stderr
