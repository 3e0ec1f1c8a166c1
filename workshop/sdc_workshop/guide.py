"""Reads the guide as a machine does: its fenced blocks, and what each asks for. The word after the three marks is the language; what
follows it says what to do:

    bash                            type it into the terminal "work", line by line; each command ends by itself
    bash new                        the same, in a new terminal of that name
    bash terminal=world [new]       type it into the terminal "world", where it keeps running
    bash carla                      not for this machine
    text see [terminal=world]       what the last commands, or that terminal, say: these lines in this order; ... stands for anything
    text window                     titles of windows that open
    keys terminal=world             Ctrl-C in that terminal
    keys window="TITLE"             "hold KEY" or "press KEY" in that window
    LANGUAGE FILE TODO n            the body of a region of a file below src
    LANGUAGE FILE                   a whole file, below src for files of sdc_package, else in the workspace
"""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass

_BLOCK = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


class GuideError(ValueError):
    """A block that nobody can follow; the message names its line and the mend."""


@dataclass(frozen=True)
class Block:
    """A fenced block. `does` is one of run, skip, see, window, keys and write; `line` counts from 1."""

    line: int
    does: str
    text: str
    terminal: str = "work"
    new: bool = False
    window: str | None = None
    file: str | None = None
    todo: str | None = None


def read(guide: str) -> list:
    """The blocks of a guide, in order. Raises GuideError."""
    return [
        _block(guide.count("\n", 0, match.start()) + 1, match[1], shlex.split(match[2]), match[3])
        for match in _BLOCK.finditer(guide)
    ]


def _block(line: int, language: str, words: list, text: str) -> Block:
    named = dict(word.split("=", 1) for word in words if "=" in word)
    plain = [word for word in words if "=" not in word]
    terminal = named.get("terminal", "work")
    if language == "bash" and set(plain) <= {"new"}:
        return Block(line, "run", text, terminal, "new" in plain)
    if (language, plain) == ("bash", ["carla"]):
        return Block(line, "skip", text)
    if (language, plain) == ("text", ["see"]):
        return Block(line, "see", text, terminal)
    if (language, plain) == ("text", ["window"]):
        return Block(line, "window", text)
    if language == "keys" and not plain and len(named) == 1:
        return Block(line, "keys", text, named.get("terminal"), window=named.get("window"))
    if (
        not named
        and plain
        and "." in plain[0]
        and (len(plain) == 1 or (len(plain) == 3 and plain[1] == "TODO"))
    ):
        return Block(line, "write", text, file=plain[0], todo=plain[2] if len(plain) == 3 else None)
    raise GuideError(
        f"line {line}: what to do with '{language} {' '.join(words)}'? See sdc_workshop/guide.py for the words there are"
    )


def missing_line(wanted: str, said: str) -> str | None:
    """The first of the wanted lines that is not said, in this order; None when all are. `...` stands for anything within a line."""
    place = 0
    for line in filter(None, map(str.strip, wanted.splitlines())):
        match = re.compile(".*?".join(map(re.escape, line.split("...")))).search(said, place)
        if match is None:
            return line
        place = match.end()
    return None
