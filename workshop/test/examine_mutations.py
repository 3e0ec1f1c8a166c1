"""Apply changes of mutations.yaml and alternatives.yaml to a finished workspace, each alone.

Prints the answers of the checks as JSON on the last line. With steps, it also prints details on
standard error. Usage: examine_mutations.py WORKSPACE PART [STEP ...]
"""

import json
import sys
import time
from pathlib import Path

import yaml

from sdc_workshop.exam.examination import Examination
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.regions import body, replaced
from sdc_workshop.steps import LABS, WORKSHOP, find_step, lesson_folder


def mutations():
    return _load("mutations.yaml")


def alternatives():
    return _load("alternatives.yaml")


def selection(part):
    """Return the first mistake of each file (part 0), or one half of all other changes (1 or 2)."""
    files = set()
    first, others = [], []
    for mutation in mutations():
        file = find_step(mutation["step"]).file
        (others if file in files else first).append(mutation)
        files.add(file)
    return first if part == 0 else [*others, *alternatives()][part - 1 :: 2]


def _load(name):
    files = [lesson_folder(lab) / name for lab in (WORKSHOP, *LABS)]
    return [row for path in files for row in yaml.safe_load(path.read_text(encoding="utf-8"))]


def mutated(text, step, mutation):
    """Return the file with this change."""
    region = body(text, step.todo) if step.todo else text
    count = region.count(mutation["old"])
    if count != 1:
        raise ValueError(
            f"{step.id}, {mutation['name']}: '{mutation['old']}' is there {count} times"
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
    folder, part = Path(sys.argv[1]), int(sys.argv[2])
    wanted = sys.argv[3:]
    answers = {}
    with Stage(Student(folder)) as stage:
        for mutation in selection(part):
            if wanted and mutation["step"] not in wanted:
                continue
            start = time.monotonic()
            name = f"{mutation['step']}: {mutation['name']}"
            answers[name] = answer = examine(folder, mutation, stage).as_dict()
            expected = answer["status"] == ("wrong" if "hint" in mutation else "passed")
            hinted = all(word in answer["hint"] for word in mutation.get("hint", []))
            if wanted or not expected or not hinted:
                elapsed = time.monotonic() - start
                print(
                    f"{elapsed:.1f} s {name} {answer} expected: {mutation.get('hint')}",
                    file=sys.stderr,
                )
    print(json.dumps(answers))


if __name__ == "__main__":
    main()
