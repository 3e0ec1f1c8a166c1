"""CMakeLists.txt: CMake itself reads it, with commands that only say how they were called; and package.xml."""

from __future__ import annotations

import difflib
import re
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.subject import Subject
from sdc_workshop.exam.variant import Variant
from sdc_workshop.regions import body
from sdc_workshop.workspace import PACKAGE, SOLUTION

_LOOK = Path(__file__).with_name("probes") / "look.cmake"
_LIMIT_S = 60
_SCRIPT = re.compile(r"scripts/\S+\.py")
_CALL = re.compile(r"^look:(\w+):(.*)$", re.MULTILINE)
COMMAND = ("CarlaVehicleControl",)
PLANNERS = ("BaseWaypoint", "LocalPath", "Path", "Waypoint")


class CMakeSubject(Subject):
    """How the package is built. What CMake makes of it is looked at command by command."""

    file = f"{PACKAGE}/CMakeLists.txt"
    todos = ("1", "2", "3", "4", "5", "6")
    needs_build = False

    def problems(self, variant: Variant, stage) -> list:
        path = stage.folder / "look" / "CMakeLists.txt"
        path.parent.mkdir(exist_ok=True)
        path.write_text(variant.text, encoding="utf-8")
        done = subprocess.run(
            ["cmake", f"-DFILE={path}", "-P", str(_LOOK)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=_LIMIT_S,
            check=False,
        )
        if done.returncode != 0:
            return [_cmake_error(done.stdout, path)]
        called = [
            (name, words.split(";") if words else []) for name, words in _CALL.findall(done.stdout)
        ]
        return [
            *self._components(called),
            *self._message_files(called),
            *self._generate(called),
            *self._package(called),
            *self._install(called),
        ]

    @staticmethod
    def _words(called, command, keyword=None, stop=()):
        """All words that calls of a command have after a keyword; None without such a call."""
        rows = [words for name, words in called if name == command]
        if not rows:
            return None
        found = []
        for words in rows:
            taking = keyword is None
            for word in words:
                if word == keyword:
                    taking = True
                elif word in stop:
                    taking = False
                elif taking:
                    found.append(word)
        return found

    def _components(self, called):
        found = self._words(called, "find_package", "COMPONENTS") or []
        for wanted, why in (
            (
                "message_generation",
                "It makes Python classes of message files. (message_runtime is for those who use the messages: it comes at "
                "catkin_package.)",
            ),
            ("geometry_msgs", "Some messages have a field of this package."),
        ):
            if wanted not in found:
                yield _missing(
                    "find_package(catkin REQUIRED COMPONENTS ...)", wanted, found, "1", why
                )

    def _message_files(self, called):
        found = self._words(called, "add_message_files", "FILES", ("DIRECTORY",))
        for name, words in called:
            if name == "add_message_files" and words and "FILES" not in words:
                yield Problem(
                    "add_message_files(FILES NAME.msg ...)",
                    f"add_message_files({' '.join(words)})",
                    "The names of the files come after the word FILES.",
                    "2" if "CarlaVehicleControl.msg" in words else "5",
                )
        for messages, todo in ((COMMAND, "2"), (PLANNERS, "5")):
            for message in messages:
                if f"{message}.msg" not in (found or []):
                    yield _missing(
                        "add_message_files(FILES ...)",
                        f"{message}.msg",
                        found or [],
                        todo,
                        f"{message}.msg is a message file of its own; each has to be named, with its ending, as the file in msg/ is spelt.",
                    )
        for word in found or []:
            known = [f"{message}.msg" for message in (*COMMAND, *PLANNERS)]
            if not (SOLUTION / PACKAGE / "msg" / word).is_file():
                near = difflib.get_close_matches(word, known, 1)
                todo = "2" if near == ["CarlaVehicleControl.msg"] else "5"
                if near:
                    yield Problem("names of files in msg/", word, f"Did you mean {near[0]}?", todo)

    def _generate(self, called):
        found = self._words(called, "generate_messages", "DEPENDENCIES")
        if found is None:
            yield Problem(
                "generate_messages(DEPENDENCIES geometry_msgs std_msgs)",
                "generate_messages is not called",
                "Without generate_messages the message files are noted, but no class is made of them.",
                "3",
            )
            return
        for wanted, why in (
            ("std_msgs", "The field `Header header` comes from std_msgs."),
            ("geometry_msgs", "Obstacle.msg has a field of geometry_msgs."),
        ):
            if wanted not in found:
                yield _missing(
                    "generate_messages(DEPENDENCIES ...)",
                    wanted,
                    found,
                    "3",
                    why
                    + " After the word DEPENDENCIES stand all packages whose messages ours use.",
                )
        order = [
            name
            for name, _ in called
            if name in ("add_message_files", "generate_messages", "catkin_package")
        ]
        if order and order[-1] == "add_message_files":
            yield Problem(
                "add_message_files before generate_messages",
                "generate_messages comes first",
                "Only files that are noted before it become classes.",
                "3",
            )

    def _package(self, called):
        found = self._words(
            called,
            "catkin_package",
            "CATKIN_DEPENDS",
            ("DEPENDS", "INCLUDE_DIRS", "LIBRARIES", "CFG_EXTRAS"),
        )
        if found is None:
            yield Problem(
                "catkin_package(CATKIN_DEPENDS ...)",
                "catkin_package is not called",
                "It declares the package.",
                "4",
            )
            return
        for wanted in ("message_runtime", "std_msgs", "geometry_msgs"):
            if wanted not in found:
                yield _missing(
                    "catkin_package(CATKIN_DEPENDS ...)",
                    wanted,
                    found,
                    "4",
                    "Whoever uses this package needs it, too: to use messages takes message_runtime (to make them takes "
                    "message_generation, which is for find_package). "
                    "The word CATKIN_DEPENDS comes before the names.",
                )

    def _install(self, called):
        found = self._words(called, "catkin_install_python", "PROGRAMS", ("DESTINATION",))
        places = self._words(called, "catkin_install_python", "DESTINATION", ("PROGRAMS",))
        if found is None:
            yield Problem(
                "catkin_install_python(PROGRAMS ... DESTINATION ...)",
                "catkin_install_python is not called",
                "It names the nodes that are installed.",
                "6",
            )
            return
        for script in _SCRIPT.findall(
            body((SOLUTION / self.file).read_text(encoding="utf-8"), "6")
        ):
            if script not in found:
                yield _missing(
                    "catkin_install_python(PROGRAMS ...)",
                    script,
                    found,
                    "6",
                    f"The node {script} would be missing in the installed car; the names count from this folder.",
                )
        if set(places) != {"<bin>"}:
            yield Problem(
                "DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION}",
                f"DESTINATION {' '.join(places) or '(nothing)'}",
                "rosrun looks for programs in CATKIN_PACKAGE_BIN_DESTINATION: `DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION}` comes last.",
                "6",
            )


def _missing(command, wanted, found, todo, why) -> Problem:
    near = difflib.get_close_matches(wanted, found, 1, 0.75)
    spelt = f"Is {near[0]} misspelt? " if near else ""
    return Problem(
        f"{wanted} in {command}",
        ", ".join(found) or "nothing",
        f"{spelt}{wanted} is missing. {why}",
        todo,
    )


def _cmake_error(said, path) -> Problem:
    line = re.search(rf"{re.escape(path.name)}:(\d+)", said)
    text = " ".join(said.replace(str(path), path.name).split())
    text = re.sub(r"^.*?CMake Error (?:at|in) ?", "", text)[:300]
    return Problem(
        "a file that CMake can read",
        text,
        "Look at this line: is a bracket missing, or a command misspelt? Each command is NAME(WORDS ...).",
        line=int(line[1]) if line else None,
    )


class PackageXmlSubject(Subject):
    """package.xml: what the package needs, and when."""

    file = f"{PACKAGE}/package.xml"
    todos = ("1",)
    needs_build = False

    def problems(self, variant: Variant, stage) -> list:
        try:
            root = ElementTree.fromstring(variant.text)
        except ElementTree.ParseError as error:
            return [
                Problem(
                    "an XML file",
                    str(error),
                    "A tag is not closed, or closed with another name: <exec_depend>message_runtime</exec_depend>.",
                    line=error.position[0],
                )
            ]
        given = {
            kind: {tag.text.strip() for tag in root.iter(kind) if tag.text}
            for kind in ("depend", "build_depend", "build_export_depend", "exec_depend")
        }
        found = []
        for kind, name, why in (
            (
                "build_depend",
                "message_generation",
                "it makes the classes while the package is built",
            ),
            (
                "build_export_depend",
                "message_runtime",
                "who builds upon this package needs the messages' runtime",
            ),
            ("exec_depend", "message_runtime", "the classes need it when they are used"),
            ("build_depend", "geometry_msgs", "a field of our messages comes from it"),
            ("exec_depend", "geometry_msgs", "a field of our messages comes from it"),
        ):
            if name not in given[kind] | given["depend"]:
                other = [tag for tag, names in given.items() if name in names]
                found.append(
                    Problem(
                        f"<{kind}>{name}</{kind}>",
                        f"{name} only as {', '.join(other)}" if other else f"no {name}",
                        f"{kind} {name} is missing: {why}.",
                        "1",
                    )
                )
        return found
