"""Variants of a student's file: some regions are the student's, the others the solution's.

A step is checked on a variant in which its own region alone is the student's. So an error belongs
to that region, whatever else in the workspace is wrong or not written yet.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

from sdc_workshop.regions import body, regions, replaced, template_body
from sdc_workshop.workspace import solution_text


@dataclass(frozen=True)
class Variant:
    """One variant of a file."""

    name: str  # path relative to the src folder of the workspace
    text: str  # its text
    judged: tuple  # numbers of the regions that are the student's
    student_regions: dict  # the regions of the student's own file, by number

    def region_of(self, line: int) -> str | None:
        """Return the number of the region that contains a line of this text, from 1."""
        for number, region in regions(self.text).items():
            if region.first < line <= max(region.end, region.first + 1):
                return number
        return None

    def student_line(self, line: int | None, todo: str | None) -> int | None:
        """Return the line of the student's file that is this line here.

        For a line that is not the student's, return the first line of the region `todo`.
        """
        number = self.region_of(line) if line is not None else None
        if line is not None and number in self.judged:
            return line - regions(self.text)[number].first + self.student_regions[number].first
        if todo in self.student_regions:
            return self.student_regions[todo].line
        return None


def make(
    name: str, student_text: str, judged: Sequence[str], left_empty: Sequence[str] = ()
) -> Variant:
    """Return a variant of a student's file, whose path is relative to the src folder.

    The regions `judged` keep the student's lines, those `left_empty` get the template's, and all
    others get the solution's.

    Raises:
        RegionError: TODO lines and rules do not match
    """
    solution, text = solution_text(name), student_text
    for number, region in regions(student_text).items():
        if number in left_empty:
            text = replaced(text, number, template_body(region))
        elif number not in judged:
            text = replaced(text, number, body(solution, number))
    return Variant(name, text, tuple(judged), regions(student_text))
