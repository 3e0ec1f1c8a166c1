"""Checks of the workspace, of hello.sh, and of whether Linux can run a program."""

from __future__ import annotations

import stat
from dataclasses import replace
from typing import Sequence

from sdc_workshop.exam.answer import PASSED, UNFINISHED, Answer, listed
from sdc_workshop.exam.file_check import configuration_error
from sdc_workshop.exam.output import last_line
from sdc_workshop.exam.region_check import BUILD
from sdc_workshop.exam.stage import NEVER_RETURNED, Stage
from sdc_workshop.exam.student import NotBuilt, Student
from sdc_workshop.steps import hint_of
from sdc_workshop.workspace import PACKAGE, WORLD_SETUP

_HELLO_TIMEOUT_S = 60.0
HELLO = f"{PACKAGE}/scripts/hello.sh"
BUILT = "a workspace that is built on the world's"


def workspace_answer(student: Student, stage: Stage) -> Answer:
    """Check that the workspace is complete and built."""
    for name in (f"{PACKAGE}/package.xml", f"{PACKAGE}/CMakeLists.txt"):
        if not (student.src / name).is_file():
            return listed("given_file", f"src/{name}", name=name)
    if not (student.devel / "setup.bash").is_file():
        return Answer(UNFINISHED, BUILT, "there is no devel/setup.bash yet", BUILD)
    try:
        student.environment  # noqa: B018  raises NotBuilt
    except NotBuilt as error:
        return listed("built_wrongly", seen=error, setup=WORLD_SETUP)
    command = ["/usr/bin/env", "python3", "-c", "import sdc_package; import rospy"]
    with stage.program(command) as program:
        if program.wait() != 0:
            return listed("build_unfinished", seen=last_line(program.output), build=BUILD)
    file = f"{PACKAGE}/CMakeLists.txt"
    built = student.folder / "build" / "CMakeFiles" / "cmake.check_cache"
    # CMake writes it at the end of each configuration that succeeds.
    if not built.is_file() or built.stat().st_mtime < (student.src / file).stat().st_mtime:
        error, line = configuration_error(stage)
        if error:
            return listed("cmake_configures", f"src/{file}", line, error=error)
    return Answer(PASSED)


def hello_answer(student: Student, stage: Stage) -> Answer:
    """Check that hello.sh runs and prints a greeting."""
    file, text = f"src/{HELLO}", student.text(HELLO)
    if not (text or "").strip():
        seen = "it does not exist yet" if text is None else "it is empty"
        return Answer(UNFINISHED, f"the file {file}", seen, hint_of("hello").hint, file)
    problem = interpreter_problem(text or "", ("bash", "sh"), "#!/usr/bin/env bash")
    if problem is not None:
        return replace(problem, file=file, line=1)
    problem = permission_problem(student, HELLO)
    if problem is not None:
        return replace(problem, file=file)
    try:
        with stage.program(["rosrun", PACKAGE, "hello.sh"]) as program:
            status, output = program.wait(_HELLO_TIMEOUT_S), program.output
    except NotBuilt as error:
        return listed("not_built", file, seen=error, build=BUILD)
    if status is None:
        stage.report(NEVER_RETURNED)
        return listed("still_runs", file, last=last_line(output))
    if status != 0:
        return listed("exit_status", file, status=status, last=last_line(output))
    return Answer(PASSED) if output.strip() else listed("no_greeting", file)


def interpreter_problem(text: str, names: Sequence[str], example: str) -> Answer | None:
    """Return what is wrong with the first line of a program, or None.

    It must name one of these interpreters, such as the example does.
    """
    first = text.split("\n", 1)[0]
    path, *more = first[2:].split() or [""]
    program = [path, *more][-1].rpartition("/")[2]
    key = ""
    if not first.startswith("#!"):
        key = "no_interpreter"
    elif program not in names:
        key = "another_interpreter"
    elif path not in (f"/usr/bin/{program}", f"/bin/{program}", "/usr/bin/env"):
        key = "missing_interpreter"
    elif len(more) != (path == "/usr/bin/env"):
        key = "interpreter_words"
    texts = {"example": example, "first": first or "an empty line", "path": path}
    return listed(key, program=program or "nothing", **texts) if key else None


def permission_problem(student: Student, name: str) -> Answer | None:
    """Return why Linux cannot run a file, or None."""
    path = student.src / name
    return None if path.stat().st_mode & stat.S_IXUSR else listed("executable", name=name)
