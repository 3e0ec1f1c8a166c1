"""Make the changes of mutations.yaml and alternatives.yaml in a finished workspace, each alone.

Prints each change whose check does not answer as listed, and the number of changes. With steps, it
prints all answers about these. Usage: examine_mutations.py WORKSPACE PART [STEP ...]
"""

import sys
from pathlib import Path

import yaml

from sdc_workshop.exam.examination import Examination
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.regions import body, replaced
from sdc_workshop.steps import LABS, WORKSHOP, find_step, lesson_folder


def changes(*names):
    """Return the rows of these files of the workshop and of each lab."""
    files = [lesson_folder(lab) / name for lab in (WORKSHOP, *LABS) for name in names]
    return [row for path in files for row in yaml.safe_load(path.read_text(encoding="utf-8"))]


def selection(part):
    """Return the first mistake of each file (part 0), or one half of all other changes (1 or 2)."""
    firsts = {}
    for mutation in changes("mutations.yaml"):
        firsts.setdefault(find_step(mutation["step"]).file, mutation)
    first = list(firsts.values())
    everything = changes("mutations.yaml", "alternatives.yaml")
    return first if part == 0 else [row for row in everything if row not in first][part - 1 :: 2]


def mutated(text, step, mutation):
    """Return the file with this change."""
    region = body(text, step.todo) if step.todo else text
    count = region.count(mutation["old"])
    assert count == 1, f"{step.id}, {mutation['name']}: '{mutation['old']}' is there {count} times"
    region = region.replace(mutation["old"], mutation["new"])
    return replaced(text, step.todo, region) if step.todo else region


def examine(folder, mutation, stage):
    """Return the answer of the check."""
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


def is_as_listed(mutation, answer):
    """Return whether a mistake is explained, and other code that is right passes."""
    if "hint" not in mutation:
        return answer.status == "passed"
    explained = all(word in answer.hint for word in mutation["hint"])
    complete = answer.expected and answer.seen and answer.file
    return bool(answer.status == "wrong" and explained and complete)


def main(folder, part, *steps):
    rows = [row for row in selection(int(part)) if row["step"] in steps or not steps]
    failed = False
    with Stage(Student(Path(folder))) as stage:
        for mutation in rows:
            answer = examine(Path(folder), mutation, stage)
            right = is_as_listed(mutation, answer)
            failed = failed or not right
            if steps or not right:
                print(
                    f"{'' if right else 'WRONG '}{mutation['step']}: {mutation['name']}: {answer}"
                )
    print(f"{len(rows)} changes")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
