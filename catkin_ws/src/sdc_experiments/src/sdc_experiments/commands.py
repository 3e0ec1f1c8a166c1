"""Check the words of a command by the table of all commands, sdc_common/data/commands.json.

A word is NAME:=VALUE, NAME=VALUE, --NAME VALUE, --NAME=VALUE, a flag --NAME, or a place such as a
file. Only the standard library is imported: docker/environment checks the words of each command
before anything is installed or built.
"""

from __future__ import annotations

import difflib
import json
import math
import os
import re
import shlex
import sys
import textwrap
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Callable, Mapping, Sequence

from sdc_common.configuration import package_folder
from sdc_common.validation import suggestion

# The project. The patterns of `names` in the table begin with a package, or a folder of it.
ROOT = Path(__file__, *[".."] * 6).resolve()
TABLE: dict[str, dict[str, Any]] = json.loads(
    Path(package_folder("sdc_common"), "data/commands.json").read_text(encoding="utf-8")
)
for _entry in TABLE.values():
    if "of" in _entry:  # its arguments are names of rows of that command
        _rows = TABLE[_entry["of"]]["arguments"]
        _entry["arguments"] = {name: _rows[name] for name in _entry["arguments"]}
_NUMBERS: dict[str, type] = {"integer": int, "number": float}
_BOOLEANS = {"true": "true", "1": "true", "false": "false", "0": "false"}
_PATHS: dict[str, Callable[[str], bool]] = {
    "file": os.path.isfile,
    "folder": os.path.isdir,
    "existing": lambda path: os.path.exists(path.partition("::")[0]),
    "path": lambda path: True,
}
# Dashes or none, a name, := or = or nothing, and a value.
_WORD = re.compile(r"(-*)([^:=]*)(:?=)?(.*)", re.DOTALL)
_COLUMNS = 100
# Of more names than these, an error lists the nearest ones only.
_MOST_NAMES = 30
_NEAREST = 5


class WordError(ValueError):
    """A wrong word of a command; the message is one line with the fix."""


def parse(command: str, words: Sequence[str]) -> SimpleNamespace:
    """Return the values of a command line by name, in lower case and with _ for -.

    Values have the type of their row, and are lists where a row takes many; what is not given and
    has no default is "", or None for numbers and booleans. `command` is the command with its
    subcommand, `texts` has what was given, and `passed` the options of another program.

    Raises:
        WordError: a word is wrong; the message is one line with the fix
    """
    if _wants_help(command, words):
        print(help_text(command))
        sys.exit()
    left = list(words)
    for word in left:
        if f"{command} {word}" in TABLE:
            left.remove(word)
            return parse(f"{command} {word}", left)
    rows = TABLE[command]["arguments"]
    texts, passed = _read(command, left)
    for name, found in texts.items():
        for index, text in enumerate(found):
            problem = "" if rows[name].get("unless") in texts else _problem(rows[name], text)
            if problem:
                raise WordError(f"{_written(command, name, text)}: {problem}")
            if rows[name]["type"] == "boolean":
                found[index] = _BOOLEANS.get(text.lower(), "")
    _check_rules(command, texts)
    values: dict[str, Any] = {}
    for name, row in rows.items():
        found = texts.get(name, [] if row.get("many") else [row.get("default", "")])
        typed = [_typed(row["type"], text) for text in found]
        values[name.replace("-", "_").lower()] = typed if row.get("many") else typed[0]
    return SimpleNamespace(**values, command=command, texts=texts, passed=passed)


def called(command: str) -> str:
    """Return a command as people call it: in the project, or where the wheel is installed."""
    if command.startswith("sdc "):
        return command
    is_source = ROOT / "catkin_ws" in Path(__file__).resolve().parents
    return f"./{command}" if is_source else f"sdc {command}"


def _written(command: str, name: str, text: str | None = None) -> str:
    """Return an argument, or an argument and its value, as people write it."""
    if name.isupper():
        return name if text is None else f"'{text}'"
    is_dashed = TABLE[command].get("dashes") or TABLE[command]["arguments"][name]["type"] == "flag"
    name, sign = (f"--{name}", " ") if is_dashed else (name, ":=")
    return name if text is None else f"{name}{sign}{text}"


def _read(command: str, left: list[str]) -> tuple[dict[str, list[str]], list[str]]:
    """Return the texts of the arguments by name, and the options of another program."""
    entry = TABLE[command]
    rows, known = entry["arguments"], entry.get("passed", "").split()
    usage = f"usage: {called(command)} {entry['usage']}"
    places = [name for name in rows if name.isupper()]
    texts: dict[str, list[str]] = {}
    free: list[str] = []
    passed: list[str] = []
    while left:
        word = left.pop(0)
        dashes, name, sign, text = _WORD.fullmatch(word).groups()  # type: ignore[union-attr]
        row = rows.get(name, {}) if name not in places else {}
        if row and (sign or dashes == "--"):
            texts[name] = [text] if sign else _following(row, left)
            if not texts[name]:
                raise WordError(f"{word} needs a value; {usage}")
        elif options := _passed(word, known, left):
            passed += options
        elif dashes or sign == ":=" or not places:
            names = [_written(command, name) for name in rows if name not in places]
            names += [option.rstrip("=") for option in known]
            fix = suggestion(dashes + name, names, f"{called(command)} --help lists the arguments")
            fix = f"write {name}:=VALUE" if row else fix
            raise WordError(f"unknown argument '{word}'; {fix}")
        else:
            free.append(word)
    for name in places:
        taken = free if rows[name].get("many") else free[:1]
        free = free[len(taken) :]
        if taken:
            texts[name] = taken
        elif rows[name].get("required"):
            raise WordError(f"{name} is missing; {usage}")
    if free:
        raise WordError(f"'{free[0]}' is one word too many; {usage}")
    return texts, passed


def _following(row: Mapping[str, Any], left: list[str]) -> list[str]:
    """Remove the values of --NAME from the words that are left, and return them."""
    if row["type"] == "flag":
        return ["true"]
    taken: list[str] = []
    while left and not left[0].startswith("--") and (row.get("many") or not taken):
        taken.append(left.pop(0))
    return taken


def _passed(word: str, known: Sequence[str], left: list[str]) -> list[str]:
    """Return an option of another program, with its value; nothing if it is none."""
    option = word.partition("=")[0] if word.startswith("--") else word[:2]
    if f"{option}=" in known:
        return [word, left.pop(0)] if word == option and left else [word]
    letters = {f"-{letter}" for letter in word[1:]} if word.startswith("-") else set()
    return [word] if word in known or (letters and letters <= {*known}) else []


def known_names(row: Mapping[str, Any]) -> list[str]:
    """Return the names that a row of the table allows."""
    found, (pattern, *expressions) = list(row.get("enum", ())), row.get("names", [""])
    first, _, rest = pattern.partition("/")
    folder = Path(package_folder(first)) if first.startswith("sdc_") else ROOT / first
    for path in sorted(folder.glob(rest)) if pattern else ():
        if expressions:
            found += re.findall(expressions[0], path.read_text(encoding="utf-8"))
        else:
            found.append(path.name.partition(".")[0])
    return found


def _problem(row: Mapping[str, Any], text: str) -> str:
    """Return what is wrong with a text, "" if nothing is."""
    kind, names = row["type"], known_names(row)
    if not text and "default" not in row:
        return ""
    if kind in _NUMBERS or kind == "boolean":
        is_valid = _is_number(row, text) if kind in _NUMBERS else text.lower() in _BOOLEANS
        return "" if is_valid else f"must be {_kind(row)}"
    if row.get("parts"):
        # Beginnings of names and ranges of them, such as controller-2..local_planner.
        beginnings = {name[: end.start()] for name in names for end in re.finditer(r"[-.]|$", name)}
        is_valid = all(part.rstrip("-.") in beginnings for part in text.split(".."))
    elif kind in _PATHS:
        is_file = _PATHS[kind](os.path.expanduser(text)) and text.endswith(row.get("ending", ""))
        is_known = text in names or bool(re.fullmatch(row.get("pattern", "(?!)"), text))
        is_valid = is_known or is_file
    else:
        pattern = row.get("pattern", "" if names else ".*")
        is_valid = text in names or bool(re.fullmatch(pattern, text, re.DOTALL))
    if is_valid:
        return ""
    if not names:
        return row.get("must") or f"there is no such {kind.replace('existing', 'file or folder')}"
    unknown = "unknown name, and no such file" if kind in _PATHS else "unknown name"
    if len(names) > _MOST_NAMES:
        near = difflib.get_close_matches(text, names, _NEAREST, 0.0)
        return f"{unknown}; the nearest are {', '.join(near)}"
    allowed = f"use one of {', '.join(names)} {row.get('must', '')}".rstrip()
    return f"{unknown}; {suggestion(text, names, '')} {allowed}".replace("  ", " ")


def _is_number(row: Mapping[str, Any], text: str) -> bool:
    try:
        value = _NUMBERS[row["type"]](text)
    except ValueError:
        return False
    least, most = row.get("minimum", -math.inf), row.get("maximum", math.inf)
    return least <= value <= most and abs(value) < math.inf


def _typed(kind: str, text: str) -> Any:
    if kind == "flag":
        return text == "true"
    if kind == "boolean" or kind in _NUMBERS:
        return (text == "true" if kind == "boolean" else _NUMBERS[kind](text)) if text else None
    return text


def _check_rules(command: str, texts: Mapping[str, list[str]]) -> None:
    """Raise WordError for the first rule that the values of several arguments break.

    An argument of a rule is NAME, which is given and not its default, or NAME:=VALUE.
    """
    rows = TABLE[command]["arguments"]

    def has(argument: str) -> bool:
        name, sign, value = argument.partition(":=")
        text = texts.get(name, [""])[0]
        return text == value if sign else text not in ("", rows[name].get("default"))

    for rule in TABLE[command].get("rules", ()):
        first = next(filter(has, rule["of"]), "").partition(":=")[0]
        if first and (has(rule["with"]) if "with" in rule else not any(map(has, rule["needs"]))):
            raise WordError(f"{_written(command, first, texts[first][0])} {rule['problem']}")


def _kind(row: Mapping[str, Any]) -> str:
    """Return what a value of a row may be, for people."""
    if row["type"] not in _NUMBERS:
        return "true or false" if row["type"] == "boolean" else ", ".join(row.get("enum", ()))
    least, most = row.get("minimum"), row.get("maximum")
    limits = f"of at least {least}" if most is None else f"from {least} to {most}"
    return f"a {'whole ' * (row['type'] == 'integer')}number {limits}"


def _wants_help(command: str, words: Sequence[str]) -> bool:
    is_bare = not words and "COMMAND" in TABLE[command]["arguments"]
    return is_bare or bool({"-h", "--help"} & {*words})


def help_text(command: str) -> str:
    """Return the help of a command and its subcommands."""
    entry = TABLE[command]
    usage = f"Usage: {called(command)} {entry['usage']}"
    lines = [usage, textwrap.fill(entry["about"], _COLUMNS), ""]
    for name, row in entry["arguments"].items():
        kind, default = _kind(row), row.get("default", "")
        text = row["about"] + f" (default: {default})" * bool(default) + f" [{kind}]" * bool(kind)
        first = f"  {_written(command, name):<20} "
        lines.append(
            textwrap.fill(text, _COLUMNS, initial_indent=first, subsequent_indent=" " * 23)
        )
    parts = [help_text(name) for name in TABLE if name.startswith(f"{command} ")]
    return "\n".join([*lines, *(f"\n{part}" for part in parts)])


def _absolute(row: Mapping[str, Any], text: str) -> str:
    """Return the absolute path of an existing file or folder, or of a new one; else the text."""
    path = os.path.join(os.environ.get("PWD", os.getcwd()), os.path.expanduser(text))
    is_name = not text or row["type"] not in _PATHS or text in known_names(row)
    return text if is_name or (row["type"] != "path" and not os.path.exists(path)) else path


def shell_text(found: SimpleNamespace) -> str:
    """Return the values as an associative array `word` of Bash, and the words as an array."""
    rows, values = TABLE[found.command]["arguments"], {}
    words = list(found.passed)
    for name, row in rows.items():
        texts = [_absolute(row, text) for text in found.texts.get(name, ())]
        values[name] = " ".join(texts) if texts else _absolute(row, row.get("default", ""))
        if row["type"] != "flag":
            words += texts if name.isupper() else [f"{name}:={text}" for text in texts]
    pairs = " ".join(f"[{name}]={shlex.quote(text)}" for name, text in values.items())
    return f"declare -gA word=({pairs}); words=({' '.join(map(shlex.quote, words))})"


def main() -> int:
    """Print what docker/environment evaluates; the exit status is 2 where a word is wrong."""
    command, *words = sys.argv[1:]
    try:
        if _wants_help(command, words):
            text = f"printf '%s\\n' {shlex.quote(help_text(command))}; exit 0"
        else:
            text = shell_text(parse(command, words))
    except WordError as error:
        print(f"{os.path.basename(command)}: {error}", file=sys.stderr)
        return 2
    sys.stdout.buffer.write(os.fsencode(text))
    return 0
