"""Parse the fenced blocks of the guide, for the test that follows it.

The word after the three marks is the language; the words that follow give the action:

    bash                            type it into the terminal "work"; each command ends
    bash new                        the same, in a new terminal of that name
    bash terminal=world [new]       type it into the terminal "world", where it keeps running
    bash carla                      not for this machine
    text see [terminal=world]       expected output of the last commands, or of that terminal:
                                    these lines in this order; ... matches anything
    text window                     titles of windows that open
    keys terminal=world             Ctrl-C in that terminal
    keys window="TITLE"             "hold KEY" or "press KEY" in that window
    diff FILE                       an edit of a file below src: lines with - become those with +
    LANGUAGE FILE TODO n            the body of a region of a file below src
    LANGUAGE FILE                   a whole file: below src in sdc_package, else in the workspace
    yaml FILE line                  a section of a file below src, and its line with the new value
"""

from __future__ import annotations

import re
import shlex
from typing import NamedTuple

_BLOCK = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


class GuideError(ValueError):
    """A block without a known action; the message names its line."""


class Block(NamedTuple):
    """A fenced block: `line` of its first mark, what it `does`, its `text`, and its action's words.

    `does` is run, skip, see, window, keys, edit, write or change.
    """

    line: int
    does: str
    text: str
    terminal: str | None = "work"
    new: bool = False
    window: str | None = None
    file: str | None = None
    todo: str | None = None


def read(guide: str) -> list:
    """Return the blocks of a guide, in order. Raises GuideError."""
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
    if language == "diff" and not named and len(plain) == 1:
        return Block(line, "edit", text, file=plain[0])
    block = None if named else _block_of_a_file(line, plain, text)
    if block is None:
        raise GuideError(
            f"line {line}: unknown block '{language} {' '.join(words)}'; "
            "guide_blocks.py lists the known ones"
        )
    return block


def _block_of_a_file(line: int, words: list, text: str) -> Block | None:
    """Return a block with the words FILE, FILE TODO NUMBER or FILE line; None for other words."""
    if not words or "." not in words[0]:
        return None
    if len(words) == 1:
        return Block(line, "write", text, file=words[0])
    if len(words) == 3 and words[1] == "TODO":
        return Block(line, "write", text, file=words[0], todo=words[2])
    if words[1:] == ["line"]:
        return Block(line, "change", text, file=words[0])
    return None


def edited(text: str, block: Block) -> str:
    """Return a text after the edit of a block. Raises GuideError."""
    old, new = (
        "".join(line[1:] + "\n" for line in block.text.splitlines() if line[0] == sign)
        for sign in "-+"
    )
    if not old or text.count(old) != 1:
        raise GuideError(f"line {block.line}: {block.file} has {text.count(old)} times\n{old}")
    return text.replace(old, new)


def missing_line(wanted: str, output: str) -> str | None:
    """Return the first wanted line that the output lacks, or None.

    Args:
        wanted: lines in the order in which they must appear; `...` matches anything within a line
        output: what was printed
    """
    place = 0
    for line in filter(None, map(str.strip, wanted.splitlines())):
        match = re.compile(".*?".join(map(re.escape, line.split("...")))).search(output, place)
        if match is None:
            return line
        place = match.end()
    return None
