"""Regions of a file: the lines that a student writes at a numbered TODO.

A line `# TODO 2.4: what to do` opens a region, a rule (a comment of dashes) closes it. In XML both
are written as `<!-- -->`. There are four forms:

    # TODO 3: what to do                          the region of the template is empty
    # TODO 4: what to do (until then: return)     the region of the template holds `return`
    # TODO 1 (line 1): what to do                 the region is line 1; the rule follows at once
    # TODO 2 (given): what to do                  the template has the lines of the solution

This module works on text; it reads and writes no files.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

_OPENS = re.compile(
    r"""^(?P<indent>[ ]*)(?:\#|<!--)[ ]TODO[ ]
        (?P<number>\d+(?:\.\d+)?)(?P<first_line>[ ]\(line[ ]1\))?
        (?P<given>[ ]\(given\))?:[ ]
        (?P<title>.*?)(?:[ ]\(until[ ]then:[ ](?P<until_then>.*)\))?(?:[ ]-->)?$""",
    re.VERBOSE,
)
_RULE = re.compile(r"^[ ]*(?:# -{10,}|<!-- (?:- ){5,}-->)$")


class RegionError(ValueError):
    """TODO lines and rules that do not match; the message names the line, from 1, and the fix."""

    def __init__(self, message: str, line: int | None = None):
        super().__init__(f"line {line}: {message}" if line else message)
        self.line = line


@dataclass(frozen=True)
class Region:
    """One region of a file; lines[first:end] is its body."""

    number: str  # number of the TODO
    title: str  # what to do
    first: int  # index of the first line of the body, from 0
    end: int  # index of the line after the body
    indent: str  # spaces before the TODO line
    until_then: str | None  # the line that the template has in the region, or None
    given: bool  # whether the template keeps the lines of the solution

    @property
    def line(self) -> int:
        """Number of the body's first line, from 1."""
        return self.first + 1


def regions(text: str) -> dict:
    """Return the regions of a file by number, in the order of the file. Raises RegionError."""
    found: dict = {}
    opened, start = None, 0
    for number, line in enumerate(text.split("\n"), 1):
        opens, is_rule = _OPENS.match(line), _RULE.match(line)
        if is_rule and opened is None:
            fix = "put its TODO line back, or delete the rule"
            raise RegionError(f"this rule closes no TODO; {fix}", number)
        if opens and opened is not None:
            fix = f"put the rule back that closes TODO {opened['number']}"
            both = f"TODO {opens['number']} begins before TODO {opened['number']} is closed"
            raise RegionError(f"{both}; {fix}", number)
        if opens and opens["number"] in found:
            seen = f"TODO {opens['number']} is there twice"
            raise RegionError(f"{seen}; delete one of the two", number)
        if opens:
            opened, start = opens, number
        elif is_rule and opened is not None:
            first, end = (0, 1) if opened["first_line"] else (start, number - 1)
            texts = opened["indent"], opened["until_then"], bool(opened["given"])
            found[opened["number"]] = Region(opened["number"], opened["title"], first, end, *texts)
            opened = None
    if opened is not None:
        seen = f"TODO {opened['number']} is not closed"
        raise RegionError(f"{seen}; put the rule back that follows it", start)
    return found


def body(text: str, number: str) -> str:
    """Return the lines of a region, with their line ends. Raises RegionError."""
    region = _region(text, number)
    return "".join(line + "\n" for line in text.split("\n")[region.first : region.end])


def replaced(text: str, number: str, new_body: str) -> str:
    """Return the file with a new body in one region. Raises RegionError."""
    region = _region(text, number)
    lines = text.split("\n")
    return "\n".join(lines[: region.first] + new_body.split("\n")[:-1] + lines[region.end :])


def template_body(region: Region) -> str:
    """Return the body that the template has in a region that is not given."""
    if region.first == 0:
        return "\n"
    return "" if region.until_then is None else f"{region.indent}{region.until_then}\n"


def template(text: str) -> str:
    """Return the file with the body of the template in every region that is not given."""
    for number, region in regions(text).items():
        if not region.given:
            text = replaced(text, number, template_body(region))
    return text


def is_written(text: str, number: str) -> bool:
    """Return whether a region holds more than the template, blank lines and comments."""
    region = _region(text, number)
    return _code(body(text, number)) != _code(template_body(region))


def _code(lines: str) -> list:
    stripped = (line.strip() for line in lines.split("\n"))
    return [
        line
        for line in stripped
        if line and (line.startswith("#!") or not line.startswith(("#", "<!--")))
    ]


def _region(text: str, number: str) -> Region:
    found = regions(text)
    if number not in found:
        raise RegionError(f"there is no 'TODO {number}'; put its line and its rule back")
    return found[number]
