"""Judge the rows of mistakes.yaml and of the labs' tables, each alone in a finished workspace.

Prints each row that is not judged as listed, and at the end how many were. With steps, it prints
all answers about these. Usage: judge_mistakes.py WORKSPACE FIRST EVERY [STEP ...]: row FIRST and
each EVERYth after it; 0 1 is all. The name of a row can stand for its step.
"""

import sys
from pathlib import Path

import yaml

from sdc_workshop.exam.answer import IN_FULL
from sdc_workshop.exam.examination import Examination
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.regions import body, replaced
from sdc_workshop.steps import find_step
from sdc_workshop.workspace import PROJECT


def table():
    """Return all rows."""
    files = sorted(Path(__file__).parent.glob("mistakes*.yaml"))
    return [row for path in files for row in yaml.safe_load(path.read_text(encoding="utf-8"))]


def written(text, step, row):
    """Return the student's file."""
    region = body(text, step.todo) if step.todo else text
    if "old" in row:
        count = region.count(row["old"])
        assert count == 1, f"{step.id}, {row['name']}: '{row['old']}' is there {count} times"
    new = region.replace(row["old"], row["new"]) if "old" in row else row.get("text", region)
    new = new.replace("{project}", str(PROJECT))
    return replaced(text, step.todo, new) if step.todo else new


def judge(folder, row, stage):
    """Return the answer of the check."""
    step = find_step(row["step"])
    changed = find_step(row.get("edit", row["step"]))
    path = folder / "src" / changed.file
    text, mode = path.read_bytes(), path.stat().st_mode
    try:
        path.write_text(written(text.decode(), changed, row), encoding="utf-8")
        path.chmod(mode & ~0o111 if row.get("mode") == "-x" else mode)
        return Examination(Student(folder), stage).judge([step])[step.id]
    finally:
        path.write_bytes(text)
        path.chmod(mode)


def is_as_listed(row, answer):
    """Return whether a mistake is explained, and code that is right passes."""
    if row["says"] == "right":
        return answer.status == "passed"
    first = answer.hint.partition(IN_FULL)[0].strip()
    message = f"{answer.expected} {answer.seen} {answer.hint}"
    return bool(
        answer.status == "wrong"
        and first
        and all(word in first for word in row.get("first", ()))
        and all(word in answer.hint for word in row["says"])
        and all(word in answer.seen for word in row.get("seen", ()))
        and not any(word in message for word in row.get("unsaid", ()))
        and (answer.expected and answer.seen and (answer.file or row["step"] == "drive"))
    )


def main(folder, first, every, *steps):
    rows = table()[int(first) :: int(every)]
    rows = [row for row in rows if not steps or {row["step"], row["name"]} & {*steps}]
    wrong = 0
    # The same seed in each run: a row that is judged rightly stays so.
    with Stage(Student(Path(folder)), seed="1") as stage:
        for row in rows:
            answer = judge(Path(folder), row, stage)
            right = is_as_listed(row, answer)
            wrong += not right
            if steps or not right:
                print(f"{'' if right else 'WRONG '}{row['step']}: {row['name']}: {answer}")
    print(f"{len(rows) - wrong} of {len(rows)}")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
