"""Each typical mistake is found by the check of its step and named in its hint.

Other code that does the same passes.
"""

import json
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from examine_mutations import alternatives, mutations, selection
from finished_workspace import solved

from sdc_workshop.steps import all_steps, hint_of
from sdc_workshop.workspace import PROJECT

pytestmark = pytest.mark.slow(50)

LIMIT_S = 900


def test_each_todo_has_two_mutations_and_each_step_a_hint():
    count = Counter(mutation["step"] for mutation in mutations())
    assert [step.id for step in all_steps() if step.file and count[step.id] < 2] == []
    for step in all_steps():
        assert hint_of(step.id).hint and hint_of(step.id).more
    names = [(mutation["step"], mutation["name"]) for mutation in [*mutations(), *alternatives()]]
    assert len(names) == len(set(names))


@pytest.mark.parametrize(
    "part", [0, *(pytest.param(part, marks=pytest.mark.nightly) for part in (1, 2))]
)
def test_mutations_are_explained_and_alternatives_pass(part, tmp_path):
    folder = solved(tmp_path / "ws")
    devel = next(Path(PROJECT).glob("catkin_ws/devel/lib/python3*/dist-packages"))
    done = subprocess.run(
        [
            sys.executable,
            "-B",
            str(Path(__file__).with_name("examine_mutations.py")),
            str(folder),
            str(part),
        ],
        env={
            **os.environ,
            "PYTHONPATH": os.pathsep.join(
                [str(PROJECT / "workshop"), str(devel), os.environ.get("PYTHONPATH", "")]
            ),
        },
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    answers = json.loads(done.stdout.splitlines()[-1])
    wanted = selection(part)
    assert len(answers) == len(wanted)
    failures = []
    for mutation in wanted:
        name = f"{mutation['step']}: {mutation['name']}"
        answer = answers[name]
        if "hint" not in mutation:
            if answer["status"] != "passed":
                failures.append(f"{name} must pass\n  {answer}")
            continue
        missing = [word for word in mutation["hint"] if word not in answer["hint"]]
        if (
            answer["status"] != "wrong"
            or missing
            or not (answer["expected"] and answer["seen"] and answer["file"])
        ):
            failures.append(
                f"{name}: {answer['status']}; missing in its hint: {missing}\n  {answer}"
            )
    assert failures == [], "\n".join(failures)
