#!/usr/bin/env python3
"""Check chapters of docs/first-steps.md: check.py CHAPTER ..."""

import re
import subprocess
import sys
from pathlib import Path

import yaml

WORKSPACE = Path.home() / "first_steps_ws"
TABLE = Path(__file__).resolve().with_name("checks.yaml")


def output_of(command: str) -> str:
    """Return what a command prints in the folder src of the reader's workspace, within 15 s."""
    if not WORKSPACE.is_dir():
        return f"there is no folder {WORKSPACE}"
    line = f"source devel/setup.bash && cd src && {command}"
    shell = ["timeout", "15", "bash", "-c", line]
    pipe = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    return subprocess.run(shell, cwd=WORKSPACE, text=True, check=False, **pipe).stdout


def report(chapter: str, row: dict, always: list) -> bool:
    """Print one check with its hint; return whether it is right."""
    output = output_of(row["run"])
    right = bool(re.search(row["expected"], output, re.MULTILINE | re.DOTALL))
    print(f"{'+' if right else 'x'} {chapter}: {row['title']}")
    if not right:
        wrong = [*row.get("wrong", []), *always, ["", row["hint"]]]
        hint = next(hint for pattern, hint in wrong if re.search(pattern, output, re.MULTILINE))
        seen = " ".join(output.split()[-30:]) or "nothing"
        print(f"    command  {row['run']}\n    seen     {seen}\n    hint     {hint}")
    return right


def main(chapters: list) -> int:
    """Check these chapters; return the exit status."""
    table = yaml.safe_load(TABLE.read_text())
    always = table.pop("always")
    known = [str(one) for one in table]
    if not chapters or not set(chapters) <= set(known):
        print(f"check.py: name chapters of the lesson: {', '.join(known)}", file=sys.stderr)
        return 2
    rows = [(chapter, row) for chapter in chapters for row in table[int(chapter)]]
    return 0 if all([report(*row, always) for row in rows]) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
