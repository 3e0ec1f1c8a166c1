"""Regions of a file: what a student writes at a numbered TODO.

A line `# TODO 2.4: what to do` opens a region, a rule (a comment of dashes) closes it; in XML both stand in `<!-- -->`. Three forms:

    # TODO 3: what to do                          the template has nothing in the region
    # TODO 4: what to do (until then: return)     the template has `return` in it
    # TODO 1 (line 1): what to do                 the region is the file's first line; the rule follows at once

No file is read or written here: everything works on text.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

_OPENS = re.compile(
    r"""^(?P<indent>[ ]*)(?:\#|<!--)[ ]TODO[ ](?P<number>\d+(?:\.\d+)?)(?P<first_line>[ ]\(line[ ]1\))?:[ ]
                         (?P<title>.*?)(?:[ ]\(until[ ]then:[ ](?P<until_then>.*)\))?(?:[ ]-->)?$""",
    re.VERBOSE,
)
_RULE = re.compile(r"^[ ]*(?:# -{10,}|<!-- (?:- ){5,}-->)$")


class RegionError(ValueError):
    """A file whose TODO lines and rules do not fit together; the message names the line and the mend."""


@dataclass(frozen=True)
class Region:
    """One region. `first` and `end` count the file's lines from 0: lines[first:end] is the body. `until_then` is what stands in the
    template, or None."""

    number: str
    title: str
    first: int
    end: int
    indent: str
    until_then: str | None

    @property
    def line(self) -> int:
        """Number of the body's first line, as editors count."""
        return self.first + 1


def regions(text: str) -> dict:
    """The regions of a file by number, in the order in which they stand. Raises RegionError."""
    lines = text.split("\n")
    found = {}
    opened = None
    for index, line in enumerate(lines):
        opens = _OPENS.match(line)
        if opened is None and _RULE.match(line):
            raise RegionError(
                f"line {index + 1}: this rule closes no TODO; put its TODO line back, or delete the rule"
            )
        if opens is not None:
            if opened is not None:
                raise RegionError(
                    f"line {index + 1}: TODO {opens['number']} begins before TODO {opened[1]['number']} is closed; "
                    f"put the rule back that closes TODO {opened[1]['number']}"
                )
            if opens["number"] in found:
                raise RegionError(
                    f"line {index + 1}: TODO {opens['number']} is there twice; delete one of the two"
                )
            opened = index, opens
        elif opened is not None and _RULE.match(line):
            start, opens = opened
            first, end = (0, 1) if opens["first_line"] else (start + 1, index)
            found[opens["number"]] = Region(
                opens["number"], opens["title"], first, end, opens["indent"], opens["until_then"]
            )
            opened = None
    if opened is not None:
        raise RegionError(
            f"line {opened[0] + 1}: TODO {opened[1]['number']} is not closed; put back the rule after it"
        )
    return found


def body(text: str, number: str) -> str:
    """What stands in region `number`, with its line ends. Raises RegionError when there is no such region."""
    region = _region(text, number)
    return "".join(line + "\n" for line in text.split("\n")[region.first : region.end])


def replaced(text: str, number: str, new_body: str) -> str:
    """The file with another body in region `number`. Raises RegionError when there is no such region."""
    region = _region(text, number)
    lines = text.split("\n")
    return "\n".join(lines[: region.first] + new_body.split("\n")[:-1] + lines[region.end :])


def template_body(region: Region) -> str:
    """What stands in a region that nobody has written yet."""
    if region.first == 0:
        return "\n"
    return "" if region.until_then is None else f"{region.indent}{region.until_then}\n"


def template(text: str) -> str:
    """The file with nothing solved."""
    for number, region in regions(text).items():
        text = replaced(text, number, template_body(region))
    return text


def is_written(text: str, number: str) -> bool:
    """Whether somebody has put something of their own into region `number`: more than the template, blank lines and comments."""
    region = _region(text, number)
    return _substance(body(text, number)) != _substance(template_body(region))


def _substance(lines: str) -> list:
    stripped = (line.strip() for line in lines.split("\n"))
    return [
        line
        for line in stripped
        if line and (line.startswith("#!") or not line.startswith(("#", "<!--")))
    ]


def _region(text: str, number: str) -> Region:
    found = regions(text)
    if number not in found:
        raise RegionError(f"there is no 'TODO {number}'; put its line and the rule after it back")
    return found[number]
