"""Check launch, XML, CMake and message files: each must mean what the solution means.

roslaunch, an XML parser, CMake and genmsg read the files of the student and of the solution, and
what is missing or different in the student's is a problem. checks.yaml lists the files.
"""

from __future__ import annotations

import difflib
import itertools
import json
import re
import shutil
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path
from typing import Iterator

import yaml

from sdc_workshop.exam.answer import PASSED, Answer, listed, mistake
from sdc_workshop.exam.asked import Asked, NoAnswer
from sdc_workshop.exam.output import last_line
from sdc_workshop.exam.probes.library_probe import evaluate
from sdc_workshop.exam.region_check import RegionCheck
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.student import Student
from sdc_workshop.exam.variant import Variant
from sdc_workshop.regions import body, regions
from sdc_workshop.workspace import PACKAGE, SOLUTION, solution_text

_PROBES = Path(__file__).with_name("probes")
_MESSAGE_MISTAKES = Path(__file__).with_name("message_mistakes.yaml")
_TIMEOUT_S = 20.0
_READABLE = "a launch file that roslaunch can read"
# (key of launch_probe.py, attribute of <node>, what it is)
_ATTRIBUTES = (
    ("package", "pkg", "pkg is the package of the program"),
    ("type", "type", "type is the name of the program in scripts/, with its ending"),
    ("name", "name", "name is the name of the node, under which its parameters are stored"),
)
_CALL = re.compile(r"^call:(\w+):(.*)$", re.MULTILINE)
# A variable of CMakeLists.txt, and its value in record.cmake.
_BIN, _BIN_VALUE = "${CATKIN_PACKAGE_BIN_DESTINATION}", "<bin>"


class FileCheck(RegionCheck):
    """Checks a launch file, package.xml or CMakeLists.txt, by its entry of checks.yaml."""

    def __init__(self, file: str, table: dict):
        self.file = file
        self._solution = solution_text(file)
        self.todos = tuple(regions(self._solution))
        self.needs_build = "node" in table
        self._table = table

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See RegionCheck.problems."""
        (kind,) = self._table
        if kind != "calls":
            broken = _xml_problem(variant.text, kind)
            if broken is not None:
                return [broken]
        return list(getattr(self, f"_{kind}_problems")(variant, stage))

    def _node_problems(self, variant: Variant, stage: Stage) -> Iterator[Answer]:
        """Compare nodes and parameters, as roslaunch reads them in the student's environment."""
        folder, name, cases = stage.folder / "launch", Path(self.file).stem, self._table["node"]
        folder.mkdir(exist_ok=True)
        path = folder / Path(self.file).name
        environment, found = stage.launch_environment(), []
        # One after the other: a launch file can include any file that it sees.
        for text in (variant.text, self._solution):
            path.write_text(text, encoding="utf-8")
            with Asked(stage, "launch_probe", environment) as asked:
                try:
                    asked.begin({})
                    found.append(asked.ask("read(path, cases)", path=str(path), cases=cases))
                except (NoAnswer, KeyError, TypeError, ValueError) as error:
                    seen = str(error) or last_line(asked.program.output)
                    yield listed("unreadable_launch", seen=seen)
                    return
        path.unlink()
        student, solution = found
        if isinstance(student, str):
            yield listed("launch", error=student.replace(str(path), path.name))
        elif isinstance(solution, str):
            yield listed("unreadable_configuration", seen=solution, name=name)
        else:
            for case, got, wanted in zip(cases, student, solution):
                command_line = " ".join(["roslaunch sdc_package", path.name, *case])
                yield from _node_problems(command_line, got["nodes"], wanted["nodes"][0])
                yield from _parameter_problems(
                    command_line, name, got["parameters"], wanted["parameters"]
                )

    def _includes_problems(self, variant: Variant, stage: Stage) -> Iterator[Answer]:
        """Compare the included files, their arguments and conditions."""
        known = _documented(ElementTree.fromstring(variant.text))
        for todo in variant.judged:
            got, wanted = _includes(variant.text, todo), _includes(self._solution, todo)
            # First the files that are not included: another may be there in the place of one.
            for file, include in sorted(wanted.items(), key=lambda item: item[0] in got):
                yield from _include_problems(file, include, got, known, todo)

    def _depends_problems(self, variant: Variant, stage: Stage) -> Iterator[Answer]:
        """Compare the packages in the tags of package.xml."""
        root = ElementTree.fromstring(variant.text)
        given = {
            tag: {entry.text.strip() for entry in root.iter(tag) if entry.text}
            for tag in ("depend", *self._table["depends"])
        }
        for wanted in ElementTree.fromstring(f"<a>{body(self._solution, '1')}</a>"):
            tag, name = wanted.tag, str(wanted.text)
            if name not in given[tag] | given["depend"]:
                others = [other.tag for other in root if (other.text or "").strip() == name]
                seen = f"{name} only as {', '.join(others)}" if others else f"no {name}"
                hint = f"{tag} {name} is missing: {self._table['depends'][tag]}."
                yield mistake(f"<{tag}>{name}</{tag}>", seen, hint, "1")

    def _calls_problems(self, variant: Variant, stage: Stage) -> Iterator[Answer]:
        """Compare the calls of CMakeLists.txt, which record.cmake prints, and configure."""
        path = stage.folder / "cmake" / "CMakeLists.txt"
        path.parent.mkdir(exist_ok=True)
        command = ["cmake", f"-DFILE={path}", "-P", str(_PROBES / "record.cmake")]
        outputs = []
        for text in (self._solution, variant.text):
            path.write_text(text, encoding="utf-8")
            with stage.start(command, {"PATH": "/usr/bin:/bin"}) as program:
                status = program.wait(_TIMEOUT_S)
                outputs.append(program.output)
        if status != 0:
            yield (
                _cmake_error(outputs[-1], path)
                if status is not None
                else mistake("a file that CMake can read", "CMake does not end", "Is it a loop?")
            )
            return
        found = _CALL.findall(outputs[-1])
        calls = [(name, words.split(";") if words else []) for name, words in found]
        is_wrong = False
        for row in self._table["calls"]:
            for problem in self._call_problems(row, calls):
                is_wrong = True
                yield problem
        steps = ("add_message_files", "generate_messages", "catkin_package")
        if [name for name, _ in calls if name in steps][-1:] == ["add_message_files"]:
            yield listed("order_of_calls")
        elif not is_wrong and outputs[0] != outputs[1]:
            # What other words mean, CMake alone knows.
            error, line = configuration_error(stage, variant.text)
            if error:
                yield listed(
                    "cmake_configures", line=line, todo=variant.region_of(line), error=error
                )

    def _call_problems(self, row: dict, calls: list) -> Iterator[Answer]:
        command, keyword, until = row["command"], row["keyword"], row.get("until", ())
        form = row.get("form", f"{command}({keyword} ...)")
        mine = [words for name, words in calls if name == command]
        is_missing = "absent" in row and len(mine) < len(
            re.findall(rf"^{command}\(", self._solution, re.MULTILINE)
        )
        text = body(self._solution, row["todo"]).replace(_BIN, _BIN_VALUE)
        region = re.findall(r"[^\s()]+", text)
        right = _after(region, keyword, until) or region
        # The file may call the command a second time, for what the region does not name.
        names = set(region) - {keyword, *until, _BIN_VALUE}
        mine = [words for words in mine if names & set(words)] or mine
        for words in mine:
            if "bare" in row and words and keyword not in words and set(words) & set(right):
                seen = f"{command}({' '.join(words)})"
                yield mistake(f"{command}({keyword} NAME ...)", seen, row["bare"], row["todo"])
        found = [word for words in mine for word in _after(words, keyword, until)]
        for word in right:
            if word not in found:
                near = difflib.get_close_matches(word, {*found} - {*right}, 1, 0.75)
                spelt = f"Is {near[0]} misspelt? " if near else ""
                spelt = "Spaces alone separate words, no commas. " if "," in str(near) else spelt
                name = word.replace(_BIN_VALUE, _BIN)
                absent = f"{command} is not called for it. {row.get('absent')}"
                why = absent if is_missing and not near else row["why"]
                hint = f"{spelt}{name} is missing. {why}"
                calls_seen = [f"{command}({' '.join(words)})" for words in mine]
                seen = ", ".join(found or calls_seen) or "nothing"
                yield mistake(f"{name} in {form}", seen, hint, row["todo"])


def configuration_error(stage: Stage, text: str | None = None) -> tuple:
    """Return the first error of CMake when it configures a copy of the student's package, or "".

    A text replaces CMakeLists.txt, among the messages, programs and package.xml of the solution.
    Also return the line of the error in CMakeLists.txt, or None.
    """
    source = stage.folder / "cmake" / PACKAGE
    shutil.rmtree(source, ignore_errors=True)
    shutil.copytree(stage.student.src / PACKAGE, source, symlinks=True)
    if text is not None:
        for path in (SOLUTION / PACKAGE).glob("scripts/*"):
            (source / "scripts" / path.name).touch()
        (source / "msg").mkdir(exist_ok=True)
        for path in [SOLUTION / PACKAGE / "package.xml", *(SOLUTION / PACKAGE).glob("msg/*")]:
            shutil.copy(path, source / path.relative_to(SOLUTION / PACKAGE))
        (source / "CMakeLists.txt").write_text(text, encoding="utf-8")
    configure = 'cmake -S "$0" -B "$TMPDIR/configured" -DCATKIN_ENABLE_TESTING=OFF'
    with stage.start(["sh", "-c", configure, source], stage.world_environment) as program:
        if program.wait() == 0:
            return "", None
        output = program.output.replace(f"{source}/", "")
    error = _first_cmake_error(output)
    line = re.search(r"\bCMakeLists\.txt:(\d+)", output[output.find("CMake Error") :])
    return error or last_line(output), int(line[1]) if line else None


def _first_cmake_error(output: str) -> str:
    # Further errors are those of the program that includes the file.
    first = " ".join(output[output.find("CMake Error") :].split("Call Stack")[0].split())
    return re.sub(r"^CMake Error (?:at|in) ?", "", first)[:300]


def _xml_problem(text: str, kind: str) -> Answer | None:
    """Return why a text is no XML, or None."""
    key = "package_xml" if kind == "depends" else "xml"
    key = "xml_quotes" if set(text) & set("“”‘’„") else key
    try:
        ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        return listed(key, error=error, line=error.position[0])
    return None


def _node_problems(command: str, nodes: list, node: dict) -> Iterator[Answer]:
    if not nodes:
        yield listed("no_node", command=command, name=node["name"])
        return
    mine = next((other for other in nodes if other["name"] == node["name"]), nodes[0])
    for key, attribute, why in _ATTRIBUTES:
        right = f'{attribute}="{node[key]}"'
        if mine[key] != node[key]:
            yield mistake(right, f'{attribute}="{mine[key]}"', f"Write {right}: {why}.", "1")
    if mine["output"] != node["output"]:
        yield listed("output", got=mine["output"] or "log")
    if node["respawn"] and not mine["respawn"]:
        yield listed("respawn")


def _parameter_problems(command: str, node: str, got: dict, wanted: dict) -> Iterator[Answer]:
    """Yield each parameter that is missing or differs."""
    configuration = SOLUTION / PACKAGE / "config" / f"{node}.yaml"
    for name, right in sorted(wanted.items()):
        key = name.replace(f"/{node}/", "", 1)
        if name not in got:
            near = difflib.get_close_matches(name, got, 1, 0.8)
            how = f'Set it in <node>: <param name="{key}" .../>.'
            if configuration.is_file() and key.split("/")[0] in yaml.safe_load(
                configuration.read_text(encoding="utf-8")
            ):
                file = f"$(find sdc_package)/config/{node}.yaml"
                how = f'Load it in <node>: <rosparam command="load" file="{file}"/>.'
            seen = f"{near[0]} instead" if near else f"no such parameter after {command}"
            yield mistake(f"the parameter {name}", seen, f"{key} is missing. {how}", "1")
        elif right != got[name]:
            same_type = type(right) is type(got[name])
            texts = {"name": name, "right": json.dumps(right), "got": json.dumps(got[name])}
            about = "parameter_value" if same_type else "parameter_type"
            yield listed(about, key_name=key, command=command, **texts)


def _includes(text: str, todo: str) -> dict:
    """Return the <include> tags of a region by file: their arguments, and their condition."""
    root = ElementTree.fromstring(f"<launch>{body(text, todo)}</launch>")
    known = _documented(ElementTree.fromstring(text))
    found = {}
    for include in root.iter("include"):
        arguments = {}
        path = SOLUTION / PACKAGE / "launch" / Path(include.get("file", "")).name
        if include.get("pass_all_args") == "true" and path.is_file():
            # It passes on each argument that the included file has.
            names = known & _documented(ElementTree.parse(path).getroot())
            arguments = {name: f"$(arg {name})" for name in sorted(names)}
        for argument in include.iter("arg"):
            arguments[argument.get("name")] = argument.get("value", argument.get("default"))
        conditions = [key for key in ("if", "unless") if key in include.attrib]
        condition = " ".join(f'{key}="{include.get(key)}"' for key in conditions)
        found[include.get("file", "")] = arguments, condition
    return found


def _documented(root: ElementTree.Element) -> set:
    """Return the arguments of a launch file, which are those with a doc."""
    return {argument.get("name") for argument in root.iter("arg") if argument.get("doc")}


def _include_problems(
    file: str, include: tuple, got: dict, known: set, todo: str
) -> Iterator[Answer]:
    """Yield what is wrong with one <include>; `known` are the arguments of the launch file."""
    texts = {"todo": todo, "path": file, "short": Path(file).name, "names": ", ".join(include[0])}
    if file not in got:
        near = difflib.get_close_matches(file, got, 1, 0.6)
        seen = f'file="{near[0]}"' if near else "it is not included"
        yield listed("not_included", seen=seen, **texts)
        return
    (mine, mine_if), (wanted, condition) = got[file], include
    for name, value in wanted.items():
        if name not in mine:
            near = difflib.get_close_matches(name, mine, 1, 0.7)
            passed_on = f"passed on: {', '.join(mine) or 'nothing'}"
            seen = f"{near[0]} instead" if near else passed_on
            yield listed("not_passed_on", name=name, seen=seen, **texts)
        elif mine[name] != value:
            yield listed("another_value", name=name, value=value, got=mine[name], **texts)
    for name in mine:
        if name not in wanted and name in known:
            yield listed("passed_too_much", name=name, **texts)
    if mine_if != condition:
        always = f"{texts['short']} is always included"
        expected = f"{condition} on the include of {texts['short']}"
        texts["expected"] = expected if condition else always
        yield listed("condition", seen=mine_if or always, condition=condition or "always", **texts)


def _after(words: list, keyword: str, until: tuple) -> list:
    """Return the words after a keyword, to the next of the words `until`."""
    found: list = []
    taking = False
    for word in words:
        if word == keyword or word in until:
            taking = word == keyword
        elif taking:
            found.append(word)
    return found


def _cmake_error(output: str, path: Path) -> Answer:
    text = _first_cmake_error(output.replace(str(path), path.name))
    line = re.search(rf"{re.escape(path.name)}:(\d+)", text)
    key = "cmake_unclosed" if "missing ending" in text else "cmake"
    return listed(key, error=text, line=int(line[1]) if line else None)


def message_answer(name: str, hint: str, student: Student) -> Answer:
    """Check a message file: its fields must be those of the solution.

    The hint is for a file that is not written yet.
    """
    from genmsg import InvalidMsgSpec

    file = f"{PACKAGE}/msg/{name}.msg"
    path = f"src/{file}"
    text = student.text(file)
    if text is None:
        return _missing_message(name, hint, student)
    wanted = _fields(solution_text(file), name)
    mine: list = []
    lines: list = []
    for number, line in enumerate(text.splitlines(), start=1):
        try:
            if "=" in line.partition("#")[0]:
                raise ValueError("this makes a constant: a field has no value")
            fields = _fields(line, name)
        except (InvalidMsgSpec, ValueError) as error:
            return listed("field_per_line", path, number, text=line.strip(), error=error)
        mine += fields
        lines += [number] * len(fields)
    if not mine:
        return listed("empty_message", path, count=len(wanted), hint=hint)
    if mine == wanted:
        return Answer(PASSED)
    pairs = enumerate(itertools.zip_longest(mine, wanted))
    index, own, right = next((index, *pair) for index, pair in pairs if pair[0] != pair[1])
    line = lines[min(index, len(lines) - 1)]
    if own is None:
        return listed("missing_field", path, line, kind=right[0], field=right[1])
    if right is None:
        return listed("more_fields", path, line, count=len(wanted), kind=own[0], field=own[1])
    found = mistake(" ".join(right), " ".join(own), _field_hint(right, own, mine, len(wanted)))
    return replace(found, file=path, line=line)


def _fields(text: str, name: str) -> list:
    """Return (type, name) of each field, the type without the package of the message."""
    from genmsg import MsgContext
    from genmsg.msg_loader import load_msg_from_string

    message = load_msg_from_string(MsgContext(), text, f"{PACKAGE}/{name}")
    kinds = (
        kind.replace(f"{PACKAGE}/", "").replace("std_msgs/Header", "Header")
        for kind in message.types
    )
    return list(zip(kinds, message.names))


def _missing_message(name: str, hint: str, student: Student) -> Answer:
    file, folder = f"src/{PACKAGE}/msg/{name}.msg", student.src / PACKAGE / "msg"
    there = {path.name: path for path in folder.parent.rglob("*")}
    near = difflib.get_close_matches(f"{name}.msg", there, 1, 0.8)
    path = there[near[0]] if near else folder
    if near and not (path.parent == folder and (SOLUTION / PACKAGE / "msg" / path.name).is_file()):
        found = path.relative_to(student.src.parent)
        return listed("misspelt_message", str(found), name=file, near=found)
    return listed("no_file", file, name=file, hint=hint)


def _field_hint(wanted: tuple, seen: tuple, mine: list, count: int) -> str:
    """Return the hint of the first row of message_mistakes.yaml whose case holds."""
    texts = {"kind": wanted[0], "field": wanted[1], "seen": seen[0]}
    names = {**texts, "wanted": wanted, "mine": mine, "count": count, "name": seen[1]}
    rows = yaml.safe_load(_MESSAGE_MISTAKES.read_text(encoding="utf-8"))
    hint = next(row["hint"] for row in rows if evaluate(row["case"], dict(names)))
    return str(hint).format(**texts)
