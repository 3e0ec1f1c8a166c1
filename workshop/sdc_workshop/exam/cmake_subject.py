"""Check of CMakeLists.txt: CMake reads it, with commands that only print how they are called."""

from __future__ import annotations

import difflib
import re
from pathlib import Path
from typing import Iterator, Sequence

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.subject import Subject
from sdc_workshop.exam.variant import Variant
from sdc_workshop.regions import body
from sdc_workshop.workspace import PACKAGE, SOLUTION

_RECORD = Path(__file__).with_name("probes") / "record.cmake"
_TIMEOUT_S = 60
_SCRIPT = re.compile(r"scripts/\S+\.py")
_CALL = re.compile(r"^call:(\w+):(.*)$", re.MULTILINE)
COMMAND = ("CarlaVehicleControl",)
PLANNERS = ("BaseWaypoint", "LocalPath", "Path", "Waypoint")
_OTHER_KEYWORDS = ("DEPENDS", "INCLUDE_DIRS", "LIBRARIES", "CFG_EXTRAS")


class CMakeSubject(Subject):
    """CMakeLists.txt, TODO 1 to 6."""

    file = f"{PACKAGE}/CMakeLists.txt"
    todos = ("1", "2", "3", "4", "5", "6")
    needs_build = False

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See Subject.problems."""
        path = stage.folder / "cmake" / "CMakeLists.txt"
        path.parent.mkdir(exist_ok=True)
        path.write_text(variant.text, encoding="utf-8")
        command = ["cmake", f"-DFILE={path}", "-P", str(_RECORD)]
        with stage.start(command, {"PATH": "/usr/bin:/bin"}) as program:
            status, output = program.wait(_TIMEOUT_S), program.output
        if status is None:
            return [Problem("a file that CMake can read", "CMake does not end", "Is it a loop?")]
        if status != 0:
            return [_cmake_error(output, path)]
        calls = [(name, words.split(";") if words else []) for name, words in _CALL.findall(output)]
        return [
            *_components(calls),
            *_message_files(calls),
            *_generate(calls),
            *_package(calls),
            *_install(calls),
        ]


def _words(calls: list, command: str, keyword: str, stop: Sequence[str] = ()) -> list | None:
    """Return the words after a keyword in all calls of a command; None without such a call."""
    rows = [words for name, words in calls if name == command]
    if not rows:
        return None
    found = []
    for words in rows:
        taking = False
        for word in words:
            if word == keyword:
                taking = True
            elif word in stop:
                taking = False
            elif taking:
                found.append(word)
    return found


def _components(calls: list) -> Iterator[Problem]:
    found = _words(calls, "find_package", "COMPONENTS") or []
    if "message_generation" not in found:
        yield _missing(
            "find_package(catkin REQUIRED COMPONENTS ...)",
            "message_generation",
            found,
            "1",
            "It generates Python classes from message files. (message_runtime is for users of the "
            "messages: it belongs to catkin_package.)",
        )


def _message_files(calls: list) -> Iterator[Problem]:
    found = _words(calls, "add_message_files", "FILES", ("DIRECTORY",)) or []
    for name, words in calls:
        if name == "add_message_files" and words and "FILES" not in words:
            yield Problem(
                "add_message_files(FILES NAME.msg ...)",
                f"add_message_files({' '.join(words)})",
                "The names of the files come after the word FILES.",
                "2" if "CarlaVehicleControl.msg" in words else "5",
            )
    for messages, todo in ((COMMAND, "2"), (PLANNERS, "5")):
        for message in messages:
            if f"{message}.msg" not in found:
                yield _missing(
                    "add_message_files(FILES ...)",
                    f"{message}.msg",
                    found,
                    todo,
                    "List each message file, with its ending, spelt as in msg/.",
                )
    known = [f"{message}.msg" for message in (*COMMAND, *PLANNERS)]
    for word in found:
        near = difflib.get_close_matches(word, known, 1)
        if near and not (SOLUTION / PACKAGE / "msg" / word).is_file():
            todo = "2" if near == ["CarlaVehicleControl.msg"] else "5"
            yield Problem("names of files in msg/", word, f"Did you mean {near[0]}?", todo)


def _generate(calls: list) -> Iterator[Problem]:
    found = _words(calls, "generate_messages", "DEPENDENCIES")
    if found is None:
        yield Problem(
            "generate_messages(DEPENDENCIES std_msgs)",
            "generate_messages is not called",
            "Without generate_messages no class is generated.",
            "3",
        )
        return
    if "std_msgs" not in found:
        yield _missing(
            "generate_messages(DEPENDENCIES ...)",
            "std_msgs",
            found,
            "3",
            "The field `Header header` comes from std_msgs. After the word DEPENDENCIES list all "
            "packages whose messages ours use.",
        )
    steps = ("add_message_files", "generate_messages", "catkin_package")
    order = [name for name, _ in calls if name in steps]
    if order and order[-1] == "add_message_files":
        yield Problem(
            "add_message_files before generate_messages",
            "generate_messages comes first",
            "Classes are generated only from files that are added before.",
            "3",
        )


def _package(calls: list) -> Iterator[Problem]:
    found = _words(calls, "catkin_package", "CATKIN_DEPENDS", _OTHER_KEYWORDS)
    expected = "catkin_package(CATKIN_DEPENDS ...)"
    if found is None:
        hint = "It declares the package."
        yield Problem(expected, "catkin_package is not called", hint, "4")
        return
    for wanted in ("message_runtime", "std_msgs"):
        if wanted not in found:
            yield _missing(
                expected,
                wanted,
                found,
                "4",
                "Users of this package need it: using messages needs message_runtime (generating "
                "them needs message_generation, which belongs to find_package). The word "
                "CATKIN_DEPENDS comes before the names.",
            )


def _install(calls: list) -> Iterator[Problem]:
    found = _words(calls, "catkin_install_python", "PROGRAMS", ("DESTINATION",))
    places = _words(calls, "catkin_install_python", "DESTINATION", ("PROGRAMS",)) or []
    if found is None:
        yield Problem(
            "catkin_install_python(PROGRAMS ... DESTINATION ...)",
            "catkin_install_python is not called",
            "It installs the nodes.",
            "6",
        )
        return
    solution = (SOLUTION / PACKAGE / "CMakeLists.txt").read_text(encoding="utf-8")
    for script in _SCRIPT.findall(body(solution, "6")):
        if script not in found:
            yield _missing(
                "catkin_install_python(PROGRAMS ...)",
                script,
                found,
                "6",
                "Without it the installed package lacks a node. Paths are relative to the folder "
                "of CMakeLists.txt.",
            )
    if set(places) != {"<bin>"}:
        yield Problem(
            "DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION}",
            f"DESTINATION {' '.join(places) or '(nothing)'}",
            "rosrun finds programs in CATKIN_PACKAGE_BIN_DESTINATION: "
            "`DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION}` comes last.",
            "6",
        )


def _missing(command: str, wanted: str, found: list, todo: str, why: str) -> Problem:
    near = difflib.get_close_matches(wanted, found, 1, 0.75)
    spelt = f"Is {near[0]} misspelt? " if near else ""
    return Problem(
        f"{wanted} in {command}",
        ", ".join(found) or "nothing",
        f"{spelt}{wanted} is missing. {why}",
        todo,
    )


def _cmake_error(output: str, path: Path) -> Problem:
    line = re.search(rf"{re.escape(path.name)}:(\d+)", output)
    text = " ".join(output.replace(str(path), path.name).split())
    text = re.sub(r"^.*?CMake Error (?:at|in) ?", "", text)[:300]
    return Problem(
        "a file that CMake can read",
        text,
        "Look at this line: is a bracket missing, or a command misspelt? Each command is "
        "NAME(WORDS ...).",
        line=int(line[1]) if line else None,
    )
