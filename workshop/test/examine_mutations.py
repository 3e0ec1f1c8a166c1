"""Makes each change of a part of mutations.yaml and alternatives.yaml in a finished workspace, alone, and prints what the check of its
step says, as JSON on the last line; with steps, it also says on standard error what it does.
Usage: examine_mutations.py WORKSPACE PART PARTS [STEP ...]"""

import json
import sys
import time
from pathlib import Path

import yaml

from sdc_workshop.exam.examination import Examination
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.regions import body, replaced
from sdc_workshop.steps import find_step
from sdc_workshop.workspace import PROJECT


def mutations():
    return _load("mutations.yaml")


def alternatives():
    return _load("alternatives.yaml")


def _load(name):
    return yaml.safe_load((PROJECT / "workshop" / name).read_text(encoding="utf-8"))


def mutated(text, step, mutation):
    """The file with this mistake in it."""
    region = body(text, step.todo) if step.todo else text
    if region.count(mutation["old"]) != 1:
        raise ValueError(
            f"{step.id}, {mutation['name']}: '{mutation['old']}' is there {region.count(mutation['old'])} times"
        )
    region = region.replace(mutation["old"], mutation["new"])
    return replaced(text, step.todo, region) if step.todo else region


def examine(folder, mutation, stage):
    step = find_step(mutation["step"])
    path = folder / "src" / step.file
    text, mode = path.read_bytes(), path.stat().st_mode
    try:
        if mutation.get("mode") == "-x":
            path.chmod(mode & ~0o111)
        else:
            path.write_text(mutated(text.decode(), step, mutation), encoding="utf-8")
        return Examination(Student(folder), stage).judge([step])[step.id]
    finally:
        path.write_bytes(text)
        path.chmod(mode)


def main():
    folder, part, parts = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    wanted = sys.argv[4:]
    answers = {}
    with Stage(Student(folder)) as stage:
        for mutation in [*mutations(), *alternatives()][part::parts]:
            if wanted and mutation["step"] not in wanted:
                continue
            start = time.monotonic()
            answers[f"{mutation['step']}: {mutation['name']}"] = answer = examine(
                folder, mutation, stage
            ).as_dict()
            as_wanted = answer["status"] == ("wrong" if "hint" in mutation else "passed")
            if (
                wanted
                or not as_wanted
                or not all(word in answer["hint"] for word in mutation.get("hint", []))
            ):
                print(
                    f"{time.monotonic() - start:.1f} s {mutation['step']}: {mutation['name']} {answer} wanted {mutation.get('hint')}",
                    file=sys.stderr,
                )
    print(json.dumps(answers))


if __name__ == "__main__":
    main()
