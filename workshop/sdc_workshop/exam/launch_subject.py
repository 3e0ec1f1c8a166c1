"""Launch files: roslaunch itself reads them, in the student's environment, with the arguments that matter, beside the solution's."""

from __future__ import annotations

import difflib
import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.output import last_words
from sdc_workshop.exam.subject import Subject
from sdc_workshop.exam.variant import Variant
from sdc_workshop.regions import body
from sdc_workshop.workspace import PACKAGE, SOLUTION

_PROBE = Path(__file__).with_name("probes") / "launch_probe.py"


def xml_problem(text: str, todo: str | None = None) -> Problem | None:
    """What keeps a text from being XML."""
    try:
        ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        return Problem(
            "an XML file",
            str(error),
            "Is a tag not closed, a quote missing, or a tag closed with another name? <node .../> closes itself, <node ...> needs </node>.",
            todo,
            error.position[0],
        )
    return None


class NodeLaunchSubject(Subject):
    """A launch file that starts one node. `cases` are the arguments with which it is read."""

    todos = ("1",)

    def __init__(self, node: str, program: str, *cases):
        self.file = f"{PACKAGE}/launch/{node}.launch"
        self.node = node
        self.program = program
        self.cases = cases

    def problems(self, variant: Variant, stage) -> list:
        broken = xml_problem(variant.text, "1")
        if broken is not None:
            return [broken]
        folder = stage.folder / "launch"
        folder.mkdir(exist_ok=True)
        path = folder / f"{self.node}.launch"
        path.write_text(variant.text, encoding="utf-8")
        with stage.program(
            ["/usr/bin/env", "python3", _PROBE, json.dumps(self.cases), path, SOLUTION / self.file]
        ) as program:
            program.wait()
            if program.status != 0:
                return [
                    Problem(
                        "a launch file that roslaunch can read",
                        last_words(program.output),
                        "Its last words say why.",
                        "1",
                    )
                ]
            student, solution = json.loads(program.output.splitlines()[-1])
        if isinstance(student, str):
            return [
                Problem(
                    "a launch file that roslaunch can read",
                    student.replace(str(path), path.name),
                    "roslaunch does not understand it. Files of this package are written $(find sdc_package)/FOLDER/FILE, arguments "
                    "$(arg NAME).",
                    "1",
                )
            ]
        if isinstance(solution, str):
            return [
                Problem(
                    "a configuration that roslaunch can read",
                    solution,
                    f"Look at config/{self.node}.yaml.",
                    "1",
                )
            ]
        return [
            problem
            for case, got, wanted in zip(self.cases, student, solution)
            for problem in self._compare(case, got, wanted)
        ]

    def _compare(self, case, got, wanted):
        started = " ".join(["roslaunch sdc_package", f"{self.node}.launch", *case])
        (node,) = wanted["nodes"]
        if not got["nodes"]:
            yield Problem(
                f"{started} starts the node {self.node}",
                "it starts nothing",
                "A <node .../> belongs here.",
                "1",
            )
            return
        mine = next(
            (other for other in got["nodes"] if other["name"] == node["name"]), got["nodes"][0]
        )
        for key, why in (
            ("package", "pkg is the package that the program lies in"),
            ("type", "type is the name of the program in scripts/, with its ending"),
            ("name", "name is what the node is called, and what its parameters are found under"),
        ):
            if mine[key] != node[key]:
                attribute = {"package": "pkg"}.get(key, key)
                yield Problem(
                    f'{attribute}="{node[key]}"',
                    f'{attribute}="{mine[key]}"',
                    f'Write {attribute}="{node[key]}": {why}.',
                    "1",
                )
        if mine["output"] != node["output"]:
            yield Problem(
                'output="screen"',
                f'output="{mine["output"] or "log"}"',
                'Without output="screen" the words of the node go into a log file and nobody sees them.',
                "1",
            )
        prefix = f"/{node['name']}/"
        for name in sorted(set(wanted["parameters"]) | set(got["parameters"])):
            a, b = wanted["parameters"].get(name), got["parameters"].get(name)
            if name in wanted["parameters"] and name not in got["parameters"]:
                key = name[len(prefix) :] if name.startswith(prefix) else name
                near = difflib.get_close_matches(name, got["parameters"], 1, 0.8)
                if key.split("/")[0] in _keys(stage_file=self.node):
                    how = f'Load it inside of <node>: <rosparam command="load" file="$(find sdc_package)/config/{self.node}.yaml"/>.'
                else:
                    how = f'Set it inside of <node>: <param name="{key}" .../>.'
                yield Problem(
                    f"the parameter {name}",
                    f"{near[0]} instead" if near else f"no such parameter after {started}",
                    f"{key} is missing. {how}",
                    "1",
                )
                return
            if name in wanted["parameters"] and a != b and type(a) is type(b):
                key = name[len(prefix) :]
                yield Problem(
                    f"{name} is {json.dumps(a)} after {started}",
                    f"it is {json.dumps(b)}",
                    f"{key} has to follow the argument: compare its value=... (is a `not` missing or too much, is the argument's name "
                    "right, does a file that is loaded later set it again?).",
                    "1",
                )
                return
            if name in wanted["parameters"] and a != b:
                key = name[len(prefix) :]
                yield Problem(
                    f"{name} is {json.dumps(a)}",
                    f"it is {json.dumps(b)}",
                    f"{key} is of another type: look at type=... of its <param>.",
                    "1",
                )
                return


def _keys(stage_file: str) -> list:
    """The parameters that the configuration of a node brings along."""
    import yaml

    path = SOLUTION / PACKAGE / "config" / f"{stage_file}.yaml"
    return list(yaml.safe_load(path.read_text(encoding="utf-8"))) if path.is_file() else []


class IncludeSubject(Subject):
    """A launch file whose regions include others and hand their arguments on."""

    needs_build = False

    def __init__(self, name: str, *todos: str):
        self.file = f"{PACKAGE}/launch/{name}.launch"
        self.todos = todos

    def problems(self, variant: Variant, stage) -> list:
        broken = xml_problem(variant.text)
        if broken is not None:
            return [broken]
        solution = (SOLUTION / self.file).read_text(encoding="utf-8")
        return [
            problem
            for todo in variant.judged
            for problem in self._compare(
                _includes(variant.text, todo), _includes(solution, todo), variant.text, todo
            )
        ]

    def _compare(self, got, wanted, text, todo):
        known = {
            argument.get("name")
            for argument in ElementTree.fromstring(text).iter("arg")
            if argument.get("doc")
        }
        for file, include in wanted.items():
            short = Path(file).name
            if file not in got:
                near = difflib.get_close_matches(file, got, 1, 0.6)
                yield Problem(
                    f'<include file="{file}">',
                    f'file="{near[0]}"' if near else "it is not included",
                    f"{short} has to be included, by its path: $(find sdc_package)/launch/{short}.",
                    todo,
                )
                continue
            mine = got[file]
            for name, value in include["args"].items():
                if name not in mine["args"]:
                    near = difflib.get_close_matches(name, mine["args"], 1, 0.7)
                    yield Problem(
                        f"{name} is handed on to {short}",
                        f"{near[0]} instead"
                        if near
                        else f"handed on: {', '.join(mine['args']) or 'nothing'}",
                        f'An argument that is not handed on is lost on the way: <arg name="{name}" value="$(arg {name})"/> belongs '
                        f"into the include of {short}.",
                        todo,
                    )
                elif mine["args"][name] != value:
                    yield Problem(
                        f'{name} of {short} is "{value}"',
                        f'"{mine["args"][name]}"',
                        f'The argument {name} is handed on by value="$(arg {name})"; $(arg ...) reads it.',
                        todo,
                    )
            for name in mine["args"]:
                if name not in include["args"] and name in known:
                    yield Problem(
                        f"{short} is given {', '.join(include['args'])}",
                        f"{name}, too",
                        f"{short} knows no argument {name}: roslaunch will refuse it.",
                        todo,
                    )
            if mine["if"] != include["if"]:
                yield Problem(
                    f'if="{include["if"]}" on the include of {short}'
                    if include["if"]
                    else f"{short} is always included",
                    f'if="{mine["if"]}"' if mine["if"] else "it is always included",
                    f"if=... says when {short} is included: it is there so that `{include['if'] or 'nothing'}` decides.",
                    todo,
                )


def _includes(text: str, todo: str) -> dict:
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
