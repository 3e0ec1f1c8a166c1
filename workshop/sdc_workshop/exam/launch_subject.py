"""Checks of launch files: roslaunch loads them in the student's environment with some arguments."""

from __future__ import annotations

import difflib
import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Iterator

import yaml

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.output import last_line
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.subject import Subject
from sdc_workshop.exam.variant import Variant
from sdc_workshop.regions import body
from sdc_workshop.workspace import PACKAGE, SOLUTION

_PROBE = Path(__file__).with_name("probes") / "launch_probe.py"
_READABLE = "a launch file that roslaunch can read"
# (key of launch_probe.py, attribute of <node>, what it is)
_ATTRIBUTES = (
    ("package", "pkg", "pkg is the package of the program"),
    ("type", "type", "type is the name of the program in scripts/, with its ending"),
    ("name", "name", "name is the name of the node, under which its parameters are stored"),
)


def xml_problem(text: str, todo: str | None = None) -> Problem | None:
    """Return why a text is no XML, or None."""
    try:
        ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        return Problem(
            "an XML file",
            str(error),
            "Is a tag not closed, a quote missing, or a tag closed with another name? <node .../> "
            "closes itself, <node ...> needs </node>.",
            todo,
            error.position[0],
        )
    return None


class NodeLaunchSubject(Subject):
    """A launch file that starts one node.

    Attributes:
        node: name of the node and of its launch file
        program: the program
        cases: the arguments with which the file is loaded
    """

    todos = ("1",)

    def __init__(self, node: str, program: str, *cases: list):
        self.file = f"{PACKAGE}/launch/{node}.launch"
        self.node = node
        self.program = program
        self.cases = cases

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See Subject.problems."""
        broken = xml_problem(variant.text, "1")
        if broken is not None:
            return [broken]
        folder = stage.folder / "launch"
        folder.mkdir(exist_ok=True)
        path = folder / f"{self.node}.launch"
        path.write_text(variant.text, encoding="utf-8")
        command = ["python3", _PROBE, json.dumps(self.cases), path, SOLUTION / self.file]
        with stage.start(["/usr/bin/env", *command], stage.launch_environment()) as program:
            program.wait()
            if program.status != 0:
                hint = "The last line of its output gives the cause."
                return [Problem(_READABLE, last_line(program.output), hint, "1")]
            student, solution = json.loads(program.output.splitlines()[-1])
        if isinstance(student, str):
            hint = (
                "Write files of this package as $(find sdc_package)/FOLDER/FILE, and arguments as "
                "$(arg NAME)."
            )
            return [Problem(_READABLE, student.replace(str(path), path.name), hint, "1")]
        if isinstance(solution, str):
            hint = f"Look at config/{self.node}.yaml."
            return [Problem("a configuration that roslaunch can read", solution, hint, "1")]
        return [
            problem
            for case, got, wanted in zip(self.cases, student, solution)
            for problem in self._compare(case, got, wanted)
        ]

    def _compare(self, case: list, got: dict, wanted: dict) -> Iterator[Problem]:
        command = " ".join(["roslaunch sdc_package", f"{self.node}.launch", *case])
        (node,) = wanted["nodes"]
        if not got["nodes"]:
            expected = f"{command} starts the node {self.node}"
            yield Problem(expected, "it starts nothing", "Write a <node .../> here.", "1")
            return
        mine = next(
            (other for other in got["nodes"] if other["name"] == node["name"]), got["nodes"][0]
        )
        for key, attribute, why in _ATTRIBUTES:
            right = f'{attribute}="{node[key]}"'
            if mine[key] != node[key]:
                seen = f'{attribute}="{mine[key]}"'
                yield Problem(right, seen, f"Write {right}: {why}.", "1")
        if mine["output"] != node["output"]:
            yield Problem(
                'output="screen"',
                f'output="{mine["output"] or "log"}"',
                'Without output="screen" the output of the node goes to a log file.',
                "1",
            )
        problem = self._parameter_problem(command, got["parameters"], wanted["parameters"])
        if problem is not None:
            yield problem

    def _parameter_problem(self, command: str, got: dict, wanted: dict) -> Problem | None:
        """Return the first parameter that is missing or differs, or None."""
        prefix = f"/{self.node}/"
        for name in sorted(wanted):
            key = name[len(prefix) :] if name.startswith(prefix) else name
            if name not in got:
                near = difflib.get_close_matches(name, got, 1, 0.8)
                how = f'Set it in <node>: <param name="{key}" .../>.'
                if key.split("/")[0] in _configured(self.node):
                    file = f"$(find sdc_package)/config/{self.node}.yaml"
                    how = f'Load it in <node>: <rosparam command="load" file="{file}"/>.'
                return Problem(
                    f"the parameter {name}",
                    f"{near[0]} instead" if near else f"no such parameter after {command}",
                    f"{key} is missing. {how}",
                    "1",
                )
            right, seen = wanted[name], got[name]
            if right != seen:
                hint = f"{key} has another type: look at type=... of its <param>."
                if type(right) is type(seen):
                    hint = (
                        f"{key} must follow the argument: look at its value=... (is the name of "
                        "the argument right, does a file that is loaded later set it again?)."
                    )
                return Problem(
                    f"{name} is {json.dumps(right)} after {command}",
                    f"it is {json.dumps(seen)}",
                    hint,
                    "1",
                )
        return None


def _configured(node: str) -> list:
    """Return the parameters in the configuration of a node."""
    path = SOLUTION / PACKAGE / "config" / f"{node}.yaml"
    return list(yaml.safe_load(path.read_text(encoding="utf-8"))) if path.is_file() else []


class IncludeSubject(Subject):
    """A launch file whose regions include other files and pass their arguments on."""

    needs_build = False

    def __init__(self, name: str, *todos: str):
        self.file = f"{PACKAGE}/launch/{name}.launch"
        self.todos = todos

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See Subject.problems."""
        broken = xml_problem(variant.text)
        if broken is not None:
            return [broken]
        solution = (SOLUTION / self.file).read_text(encoding="utf-8")
        known = {
            argument.get("name")
            for argument in ElementTree.fromstring(variant.text).iter("arg")
            if argument.get("doc")
        }
        found: list = []
        for todo in variant.judged:
            got, wanted = _includes(variant.text, todo), _includes(solution, todo)
            for file, include in wanted.items():
                found += _include_problems(file, include, got, known, todo)
        return found


def _include_problems(
    file: str, include: dict, got: dict, known: set, todo: str
) -> Iterator[Problem]:
    """Yield what is wrong with one <include>; `known` are the arguments of the launch file."""
    short = Path(file).name
    if file not in got:
        near = difflib.get_close_matches(file, got, 1, 0.6)
        yield Problem(
            f'<include file="{file}">',
            f'file="{near[0]}"' if near else "it is not included",
            f"Include {short}, by its path: $(find sdc_package)/launch/{short}.",
            todo,
        )
        return
    mine, wanted = got[file]["args"], include["args"]
    for name, value in wanted.items():
        if name not in mine:
            near = difflib.get_close_matches(name, mine, 1, 0.7)
            yield Problem(
                f"{name} is passed on to {short}",
                f"{near[0]} instead" if near else f"passed on: {', '.join(mine) or 'nothing'}",
                f'An argument that is not passed on is lost: <arg name="{name}" '
                f'value="$(arg {name})"/> belongs in the include of {short}.',
                todo,
            )
        elif mine[name] != value:
            yield Problem(
                f'{name} of {short} is "{value}"',
                f'"{mine[name]}"',
                f'The argument {name} is passed on by value="$(arg {name})"; $(arg ...) reads it.',
                todo,
            )
    for name in mine:
        if name not in wanted and name in known:
            yield Problem(
                f"{short} gets {', '.join(wanted)}",
                f"{name}, too",
                f"{short} has no argument {name}: roslaunch refuses it.",
                todo,
            )
    condition, mine_if = include["if"], got[file]["if"]
    if mine_if != condition:
        always = f"{short} is always included"
        yield Problem(
            f'if="{condition}" on the include of {short}' if condition else always,
            f'if="{mine_if}"' if mine_if else always,
            f"if=... is the condition for {short}; here it is `{condition or 'always'}`.",
            todo,
        )


def _includes(text: str, todo: str) -> dict:
    """Return the <include> tags of a region by file: their arguments, and their condition."""
    root = ElementTree.fromstring(f"<launch>{body(text, todo)}</launch>")
    return {
        include.get("file", ""): {
            "args": {
                argument.get("name"): argument.get("value", argument.get("default"))
                for argument in include.iter("arg")
            },
            "if": include.get("if"),
        }
        for include in root.iter("include")
    }
