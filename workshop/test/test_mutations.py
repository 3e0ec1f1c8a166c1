"""Each typical mistake is found by the check of its step and named in its hint.

Other code that does the same passes.
"""

import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from examine_mutations import changes, selection
from finished_workspace import solved

from sdc_workshop.steps import all_steps, hint_of
from sdc_workshop.workspace import PROJECT

pytestmark = pytest.mark.slow(50)

LIMIT_S = 900


def test_each_todo_has_two_mutations_and_each_step_a_hint():
    count = Counter(mutation["step"] for mutation in changes("mutations.yaml"))
    assert [step.id for step in all_steps() if step.file and count[step.id] < 2] == []
    assert all(hint_of(step.id).hint and hint_of(step.id).more for step in all_steps())
    rows = changes("mutations.yaml", "alternatives.yaml")
    assert len({(row["step"], row["name"]) for row in rows}) == len(rows)


@pytest.mark.parametrize(
    "part", [0, *(pytest.param(part, marks=pytest.mark.nightly) for part in (1, 2))]
)
def test_mutations_are_explained_and_alternatives_pass(part, tmp_path):
    folder = solved(tmp_path / "ws")
    devel = next(Path(PROJECT).glob("catkin_ws/devel/lib/python3*/dist-packages"))
    path = [str(PROJECT / "workshop"), str(devel), os.environ.get("PYTHONPATH", "")]
    done = subprocess.run(
        [sys.executable, "-B", Path(__file__).with_name("examine_mutations.py"), folder, str(part)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(path)},
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[-1] == f"{len(selection(part))} changes"
