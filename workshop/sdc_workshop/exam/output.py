"""Read a program's output: the error that ended it, its line in the student's file, its meaning."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import yaml

_TRACEBACK = re.compile(
    r"Traceback \(most recent call last\):\n(?P<frames>(?:[ \t].*\n|\n)*?)"
    r"(?P<error>[A-Za-z_][\w.]*(?::.*|$))",
    re.MULTILINE,
)
_FRAME = re.compile(r'^\s*File "(?P<file>[^"]+)", line (?P<line>\d+)', re.MULTILINE)
_SYNTAX = re.compile(
    r'^\s*File "(?P<file>[^"]+)", line (?P<line>\d+)\n(?P<shown>(?:[ \t].*\n)*)'
    r"(?P<error>(?:Syntax|Indentation|Tab)Error: .*)",
    re.MULTILINE,
)
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_UNKNOWN = (
    "Read the last line of the error first; it happened in the line of your file that is named "
    "above."
)
_LOGGED = re.compile(r"^\[(?:FATAL|ERROR|WARN)\] \[[^\]]*\]:? ?(?P<text>.*)", re.MULTILINE)


@dataclass(frozen=True)
class Crash:
    """An exception that a program did not catch."""

    error: str  # its type and text
    line: int | None  # the last line of the program's own file in the traceback, from 1, or None
    library_line: str | None = None  # file and line that raised it, where that is another file
    file: str | None = None  # the program's own file, or None

    @property
    def kind(self) -> str:
        """Name of the exception's class."""
        return self.error.partition(":")[0].rpartition(".")[2]

    @property
    def text(self) -> str:
        """Text of the exception."""
        return self.error.partition(":")[2].strip()


def plain(output: str) -> str:
    """Return the output without colours."""
    return _COLOUR.sub("", output)


def crash(output: str, path: Path) -> Crash | None:
    """Return the first uncaught exception of the program in a file, or of those in a folder."""
    output = plain(output) + "\n"
    syntax = _SYNTAX.search(output)
    if syntax:
        line = int(syntax["line"])
        if syntax["file"] == str(path):
            return Crash(syntax["error"], line)
        return Crash(syntax["error"], None, f"{Path(syntax['file']).name}, line {line}")
    found = _TRACEBACK.search(output)
    if not found:
        return None
    frames = [(frame["file"], int(frame["line"])) for frame in _FRAME.finditer(found["frames"])]
    own = [(file, line) for file, line in frames if path in (Path(file), *Path(file).parents)]
    last = frames[-1] if frames else None
    beyond = f"{Path(last[0]).name}, line {last[1]}" if last and last not in own else None
    file, line = own[-1] if own else (None, None)
    return Crash(found["error"].strip(), line, beyond, file)


def last_line(output: str) -> str:
    """Return the last warning or error that was logged; without one, the last line."""
    logged = _LOGGED.findall(plain(output))
    lines = logged or [line.strip() for line in plain(output).splitlines() if line.strip()]
    return lines[-1] if lines else "no output"


def warnings(output: str) -> list:
    """Return all warnings and errors that were logged."""
    return _LOGGED.findall(plain(output))


@lru_cache(maxsize=1)
def _meanings() -> list:
    return yaml.safe_load(Path(__file__).with_name("meanings.yaml").read_text(encoding="utf-8"))


def meaning(crash: Crash, program: str = "", unknown: str = _UNKNOWN) -> str:
    """Return what an exception in a program means and how to fix it, for a beginner."""
    for kind, pattern, text, *nearby in _meanings():
        match = re.search(pattern, crash.text) if crash.kind == kind else None
        found = match and re.search("".join(nearby).format(*match.groups()), program)
        if match and found:
            return text.format(*match.groups(), *found.groups())
    return unknown
