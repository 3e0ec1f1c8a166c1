"""Steps in which a whole file is written, or none."""

from __future__ import annotations

import difflib
import os
import stat

from sdc_workshop.exam.answer import PASSED, UNFINISHED, WAITING, WRONG, Answer, Problem, wrong
from sdc_workshop.exam.hints import hint_of
from sdc_workshop.exam.output import last_words
from sdc_workshop.exam.student import NotBuilt
from sdc_workshop.exam.subject import BUILD
from sdc_workshop.workspace import PACKAGE, SOLUTION

_HELLO_LIMIT_S = 20.0
HELLO = f"{PACKAGE}/scripts/hello.sh"


def workspace_answer(student, stage) -> Answer:
    """Whether the workspace is there and built."""
    for name in (f"{PACKAGE}/package.xml", f"{PACKAGE}/CMakeLists.txt", "sdc_world/CMakeLists.txt"):
        if student.text(name) is None:
            return Answer(
                WRONG,
                f"the file src/{name}",
                "it is not there",
                "Make a new workspace with ./workshop/start, or bring the file back from it.",
                f"src/{name}",
            )
    if not (student.devel / "setup.bash").is_file():
        return Answer(
            UNFINISHED, "a workspace that is built", "there is no devel/setup.bash yet", BUILD
        )
    try:
        environment = student.environment
    except NotBuilt as error:
        return Answer(
            WRONG,
            "a workspace that is built",
            str(error),
            "Delete the folders build and devel, open a new terminal, and run `catkin_make` in the workspace.",
        )
    with stage.program(
        ["/usr/bin/env", "python3", "-c", "import sdc_package; import rospy"]
    ) as program:
        if program.wait() != 0:
            return Answer(
                WRONG,
                "a workspace that is built to its end",
                last_words(program.output),
                f"The build has not come to its end. {BUILD} The first line with `error` counts.",
            )
    if "sdc_sim" not in environment["ROS_PACKAGE_PATH"]:
        return Answer(
            WRONG,
            "the world: ROS finds sdc_sim",
            f"ROS_PACKAGE_PATH is {environment['ROS_PACKAGE_PATH']}",
            f"Leave src/sdc_world as it was. {BUILD}",
        )
    return Answer(PASSED)


def message_answer(name: str, hint: str, student) -> Answer:
    """Whether a message has the fields that the rest of the world knows; `hint` is for one that is not there yet."""
    from genmsg import InvalidMsgSpec, MsgContext
    from genmsg.msg_loader import load_msg_from_string

    file = f"{PACKAGE}/msg/{name}.msg"
    text = student.text(file)
    if text is None:
        folder = student.src / PACKAGE / "msg"
        near = difflib.get_close_matches(
            f"{name}.msg", os.listdir(folder) if folder.is_dir() else [], 1, 0.8
        )
        if near and not (SOLUTION / PACKAGE / "msg" / near[0]).is_file():
            return Answer(
                WRONG,
                f"the file src/{file}",
                f"there is {near[0]}",
                "Is the name misspelt? Rename it: capital and small letters count.",
                f"src/{PACKAGE}/msg/{near[0]}",
            )
        return Answer(
            UNFINISHED, f"the file src/{file}", "it is not there yet", hint, f"src/{file}"
        )
    wanted = load_msg_from_string(
        MsgContext(), (SOLUTION / file).read_text(encoding="utf-8"), f"{PACKAGE}/{name}"
    )
    if not any(line.split("#")[0].strip() for line in text.splitlines()):
        return Answer(
            UNFINISHED,
            f"{len(wanted.names)} fields, one a line",
            "it is empty",
            hint,
            f"src/{file}",
        )
    for number, line in enumerate(text.splitlines(), start=1):
        try:
            load_msg_from_string(MsgContext(), line, f"{PACKAGE}/{name}")
        except (InvalidMsgSpec, ValueError) as error:
            return wrong(
                Problem(
                    "one field a line: TYPE NAME",
                    f"{line.strip()} ({error})",
                    "A line has a type, a space, and a name; nothing else but a comment after #.",
                ),
                f"src/{file}",
                number,
            )
    got = load_msg_from_string(MsgContext(), text, f"{PACKAGE}/{name}")
    rows = [
        number
        for number, line in enumerate(text.splitlines(), start=1)
        if line.split("#")[0].strip() and "=" not in line
    ]
    fields, mine = (
        list(zip(map(_short, wanted.types), wanted.names)),
        list(zip(map(_short, got.types), got.names)),
    )
    for index, (kind, field) in enumerate(fields):
        line = rows[index] if index < len(rows) else (rows[-1] if rows else 1)
        if index >= len(mine):
            return wrong(
                Problem(
                    f"{kind} {field}", "no such field", f"The field {field} is missing at the end."
                ),
                f"src/{file}",
                line,
            )
        if mine[index] == (kind, field):
            continue
        seen = " ".join(mine[index])
        if (kind, field) in mine:
            hint = f"{field} is there, but in another place: the order of the fields counts."
        elif mine[index][1] == field:
            hint = f"{field} has to be of type {kind}, not {mine[index][0]}." + (
                " The brackets [] say that there are many."
                if "[]" in kind and "[]" not in mine[index][0]
                else ""
            )
        elif tuple(reversed(mine[index])) == (kind, field):
            hint = f"A line has the type first and the name second: {kind} {field}."
        elif mine[index][0] == kind and field not in got.names and len(mine) >= len(fields):
            hint = f"The name is {field}, to the letter: other programs know it by this name."
        else:
            hint = f"The field {field} is missing here."
        return wrong(Problem(f"{kind} {field}", seen, hint), f"src/{file}", line)
    if len(mine) > len(fields):
        return wrong(
            Problem(
                f"{len(fields)} fields",
                f"one more: {' '.join(mine[len(fields)])}",
                f"{mine[len(fields)][1]} is too much: programs with another list of fields are not understood.",
            ),
            f"src/{file}",
            rows[len(fields)] if len(rows) > len(fields) else None,
        )
    return Answer(PASSED)


def _short(kind: str) -> str:
    return kind.replace(f"{PACKAGE}/", "").replace("std_msgs/Header", "Header")


def hello_answer(student, stage) -> Answer:
    """Whether hello.sh runs and greets."""
    text = student.text(HELLO)
    file = f"src/{HELLO}"
    if not (text or "").strip():
        return Answer(
            UNFINISHED,
            f"the file {file}",
            "it is not there yet" if text is None else "it is empty",
            hint_of("hello").hint,
            file,
        )
    problem = interpreter_problem(text, ("bash", "sh"), "#!/usr/bin/env bash")
    if problem is not None:
        return wrong(problem, file, 1)
    problem = permission_problem(student, HELLO)
    if problem is not None:
        return wrong(problem, file)
    try:
        with stage.program(["rosrun", PACKAGE, "hello.sh"]) as program:
            status = program.wait(_HELLO_LIMIT_S)
            output = program.output
    except NotBuilt as error:
        return Answer(WAITING, "a workspace that is built", str(error), BUILD, file)
    if status is None:
        return wrong(
            Problem(
                "a greeting, and then the end",
                f"it goes on; until now it said: {last_words(output)}",
                "It is to say one thing and end.",
            ),
            file,
        )
    if status != 0:
        return wrong(
            Problem(
                "exit status 0",
                f"exit status {status}: {last_words(output)}",
                "bash names the line that it did not understand.",
            ),
            file,
        )
    if not output.strip():
        return wrong(
            Problem(
                "a greeting on the screen",
                "it says nothing",
                'echo "Hello!" says something; the quotes go around all of it.',
            ),
            file,
        )
    return Answer(PASSED)


def interpreter_problem(text: str, names, example: str) -> Problem | None:
    """What is wrong with the first line of a program."""
    first = text.split("\n", 1)[0]
    expected = f"line 1 is {example}"
    if not first.startswith("#!"):
        return Problem(
            expected,
            first or "an empty line",
            f"It begins with the two characters #! in the very first column of line 1: {example}",
        )
    words = first[2:].split()
    program = words[-1].rpartition("/")[2] if words else ""
    if program not in names:
        return Problem(
            expected,
            first,
            f"This asks for `{program or 'nothing'}`, which is not the interpreter of this file: {example}",
        )
    if words[0] not in (f"/usr/bin/{program}", f"/bin/{program}", "/usr/bin/env") or (
        len(words) == 1 and words[0].endswith("/env")
    ):
        return Problem(expected, first, f"There is no {words[0]}: {example} lets env look for it.")
    if len(words) != (2 if words[0] == "/usr/bin/env" else 1):
        return Problem(
            expected, first, f"There is too much, or too little, in this line: {example}"
        )
    return None


def permission_problem(student, name: str) -> Problem | None:
    """Why Linux would not run a program, whatever stands in it."""
    path = student.src / name
    if path.read_bytes().partition(b"\n")[0].endswith(b"\r"):
        return Problem(
            "lines that end as on Linux",
            "they end as on Windows",
            "Save the file with Unix line ends (LF, not CRLF): Linux looks "
            f"for an interpreter whose name ends in an invisible character. sed -i 's/\\r$//' src/{name} mends it.",
        )
    if path.stat().st_mode & stat.S_IXUSR:
        return None
    return Problem(
        f"src/{name} may be run", "it has no permission to be run (x)", f"chmod +x src/{name}"
    )
