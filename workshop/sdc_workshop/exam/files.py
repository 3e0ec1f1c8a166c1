"""Checks of the workspace, of hello.sh, and of whether Linux can run a program."""

from __future__ import annotations

import stat
from typing import Sequence

from sdc_workshop.exam.answer import PASSED, UNFINISHED, Answer, Problem, answered, listed, wrong
from sdc_workshop.exam.file_check import configuration_error
from sdc_workshop.exam.output import last_line
from sdc_workshop.exam.region_check import BUILD, unreadable
from sdc_workshop.exam.stage import NEVER_RETURNED, Stage
from sdc_workshop.exam.student import NotBuilt, Student
from sdc_workshop.steps import hint_of
from sdc_workshop.student_file import FileError
from sdc_workshop.workspace import PACKAGE, WORLD_SETUP

_HELLO_TIMEOUT_S = 60.0
HELLO = f"{PACKAGE}/scripts/hello.sh"
BUILT = "a workspace that is built on the world's"


def workspace_answer(student: Student, stage: Stage) -> Answer:
    """Check that the workspace is complete and built."""
    for name in (f"{PACKAGE}/package.xml", f"{PACKAGE}/CMakeLists.txt"):
        if not (student.src / name).is_file():
            return answered("given_file", f"src/{name}", name=name)
    if not (student.devel / "setup.bash").is_file():
        return Answer(UNFINISHED, BUILT, "there is no devel/setup.bash yet", BUILD)
    try:
        student.environment  # noqa: B018  raises NotBuilt
    except NotBuilt as error:
        return answered("built_wrongly", seen=error, setup=WORLD_SETUP)
    command = ["/usr/bin/env", "python3", "-c", "import sdc_package; import rospy"]
    with stage.program(command) as program:
        if program.wait() != 0:
            return answered("build_unfinished", seen=last_line(program.output), build=BUILD)
    file = f"{PACKAGE}/CMakeLists.txt"
    built = student.folder / "build" / "CMakeFiles" / "cmake.check_cache"
    # CMake writes it at the end of each configuration that succeeds.
    if not built.is_file() or built.stat().st_mtime < (student.src / file).stat().st_mtime:
        error, line = configuration_error(stage)
        if error:
            return wrong(listed("cmake_configures", error=error), f"src/{file}", line)
    return Answer(PASSED)


def hello_answer(student: Student, stage: Stage) -> Answer:
    """Check that hello.sh runs and prints a greeting."""
    file = f"src/{HELLO}"
    try:
        text = student.text(HELLO)
    except FileError as error:
        return unreadable(error, file)
    if not (text or "").strip():
        seen = "it does not exist yet" if text is None else "it is empty"
        return Answer(UNFINISHED, f"the file {file}", seen, hint_of("hello").hint, file)
    problem = interpreter_problem(text or "", ("bash", "sh"), "#!/usr/bin/env bash")
    if problem is not None:
        return wrong(problem, file, 1)
    problem = permission_problem(student, HELLO)
    if problem is not None:
        return wrong(problem, file)
    try:
        with stage.program(["rosrun", PACKAGE, "hello.sh"]) as program:
            status = program.wait(_HELLO_TIMEOUT_S)
            output = program.output
            if status is None:
                stage.report(NEVER_RETURNED)
    except NotBuilt as error:
        return answered("not_built", file, seen=error, build=BUILD)
    if status is None:
        return answered("still_runs", file, last=last_line(output))
    if status != 0:
        return answered("exit_status", file, status=status, last=last_line(output))
    return Answer(PASSED) if output.strip() else answered("no_greeting", file)


def interpreter_problem(text: str, names: Sequence[str], example: str) -> Problem | None:
    """Return what is wrong with the first line of a program, or None.

    It must name one of these interpreters, such as the example does.
    """
    first = text.split("\n", 1)[0]
    texts = {"example": example, "first": first or "an empty line"}
    if not first.startswith("#!"):
        return listed("no_interpreter", **texts)
    words = first[2:].split()
    program = words[-1].rpartition("/")[2] if words else ""
    if program not in names:
        return listed("another_interpreter", program=program or "nothing", **texts)
    if words[0] not in (f"/usr/bin/{program}", f"/bin/{program}", "/usr/bin/env") or (
        len(words) == 1 and words[0].endswith("/env")
    ):
        return listed("missing_interpreter", path=words[0], **texts)
    if len(words) != (2 if words[0] == "/usr/bin/env" else 1):
        return listed("interpreter_words", **texts)
    return None


def permission_problem(student: Student, name: str) -> Problem | None:
    """Return why Linux cannot run a file, or None."""
    path = student.src / name
    return None if path.stat().st_mode & stat.S_IXUSR else listed("executable", name=name)
