"""Check of a message file: its fields must be those of the other nodes."""

from __future__ import annotations

import difflib
import os
from typing import TYPE_CHECKING

from sdc_workshop.exam.answer import PASSED, UNFINISHED, WRONG, Answer, Problem, wrong
from sdc_workshop.exam.student import Student
from sdc_workshop.workspace import PACKAGE, SOLUTION

if TYPE_CHECKING:
    from genmsg import MsgSpec


def message_answer(name: str, hint: str, student: Student) -> Answer:
    """Check one message file.

    Args:
        name: name of the message
        hint: hint for a file that is not written yet
        student: the workspace
    """
    file = f"{PACKAGE}/msg/{name}.msg"
    text = student.text(file)
    if text is None:
        return _missing_file(name, hint, student)
    wanted = _parsed((SOLUTION / file).read_text(encoding="utf-8"), name)
    if not any(line.split("#")[0].strip() for line in text.splitlines()):
        expected = f"{len(wanted.names)} fields, one per line"
        return Answer(UNFINISHED, expected, "it is empty", hint, f"src/{file}")
    problem = _syntax_problem(text, name)
    if problem is None:
        problem = _field_problem(text, _parsed(text, name), wanted)
    return Answer(PASSED) if problem is None else wrong(problem, f"src/{file}", problem.line)


def _parsed(text: str, name: str) -> MsgSpec:
    from genmsg import MsgContext
    from genmsg.msg_loader import load_msg_from_string

    return load_msg_from_string(MsgContext(), text, f"{PACKAGE}/{name}")


def _missing_file(name: str, hint: str, student: Student) -> Answer:
    file, folder = f"src/{PACKAGE}/msg/{name}.msg", student.src / PACKAGE / "msg"
    there = os.listdir(folder) if folder.is_dir() else []
    near = difflib.get_close_matches(f"{name}.msg", there, 1, 0.8)
    if near and not (SOLUTION / PACKAGE / "msg" / near[0]).is_file():
        return Answer(
            WRONG,
            f"the file {file}",
            f"there is {near[0]}",
            "Is the name misspelt? Rename it: upper and lower case matter.",
            f"src/{PACKAGE}/msg/{near[0]}",
        )
    return Answer(UNFINISHED, f"the file {file}", "it does not exist yet", hint, file)


def _syntax_problem(text: str, name: str) -> Problem | None:
    from genmsg import InvalidMsgSpec

    for number, line in enumerate(text.splitlines(), start=1):
        try:
            _parsed(line, name)
        except (InvalidMsgSpec, ValueError) as error:
            return Problem(
                "one field per line: TYPE NAME",
                f"{line.strip()} ({error})",
                "A line has a type, a space, and a name; only a comment after # may follow.",
                line=number,
            )
    return None


def _field_problem(text: str, got: MsgSpec, wanted: MsgSpec) -> Problem | None:
    rows = [
        number
        for number, line in enumerate(text.splitlines(), start=1)
        if line.split("#")[0].strip() and "=" not in line
    ]
    fields = list(zip(map(_short, wanted.types), wanted.names))
    mine = list(zip(map(_short, got.types), got.names))
    for index, (kind, field) in enumerate(fields):
        line = rows[index] if index < len(rows) else (rows[-1] if rows else 1)
        if index >= len(mine):
            hint = f"The field {field} is missing at the end."
            return Problem(f"{kind} {field}", "no such field", hint, line=line)
        if mine[index] != (kind, field):
            hint = _field_hint((kind, field), mine[index], mine, len(fields))
            return Problem(f"{kind} {field}", " ".join(mine[index]), hint, line=line)
    if len(mine) > len(fields):
        kind, field = mine[len(fields)]
        return Problem(
            f"{len(fields)} fields",
            f"one more: {kind} {field}",
            f"{field} is too much: ROS connects nodes only if their messages have the same fields.",
            line=rows[len(fields)] if len(rows) > len(fields) else None,
        )
    return None


def _field_hint(wanted: tuple, seen: tuple, mine: list, count: int) -> str:
    kind, field = wanted
    if wanted in mine:
        return f"{field} is in another place: the order of the fields matters."
    if seen[1] == field:
        array = "[]" in kind and "[]" not in seen[0]
        hint = f"{field} must be of type {kind}, not {seen[0]}."
        return f"{hint} The brackets [] make an array." if array else hint
    if (seen[1], seen[0]) == wanted:
        return f"The type comes first, then the name: {kind} {field}."
    if seen[0] == kind and field not in [name for _, name in mine] and len(mine) >= count:
        return f"The name is {field}, letter for letter: other nodes use this name."
    return f"The field {field} is missing here."


def _short(kind: str) -> str:
    return kind.replace(f"{PACKAGE}/", "").replace("std_msgs/Header", "Header")
