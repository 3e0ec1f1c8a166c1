"""Variants of a student's file: some regions are the student's, the rest the solution's or nobody's.

A step is judged on a variant in which nothing but its own region is the student's. What goes wrong there is that region's doing, whatever
else in the workspace is wrong or not yet written.
"""

from __future__ import annotations

from dataclasses import dataclass

from sdc_workshop.regions import Region, body, regions, replaced, template_body
from sdc_workshop.workspace import SOLUTION


@dataclass(frozen=True)
class Variant:
    """The text of such a file. `name` is relative to the src folder of the workspace; `judged` are the regions that are the student's."""

    name: str
    text: str
    judged: tuple
    student_regions: dict

    def region_of(self, line: int) -> str | None:
        """Number of the region that a line of this text, counted from 1, lies in."""
        for number, region in regions(self.text).items():
            if region.first < line <= max(region.end, region.first + 1):
                return number
        return None

    def student_line(self, line: int | None, todo: str | None) -> int | None:
        """The line of the student's own file that stands on this line here, or else the first line of the region `todo`."""
        number = self.region_of(line) if line is not None else None
        if number in self.judged:
            return line - regions(self.text)[number].first + self.student_regions[number].first
        if todo in self.student_regions:
            return first_line(self.student_regions[todo])
        return None


def first_line(region: Region) -> int:
    """Where a student writes the first line of a region, counted from 1."""
    return region.first + 1


def make(name: str, student_text: str, judged, left_empty=()) -> Variant:
    """The student's file with the solution in all regions but those `judged`, and nothing in those that are to be `left_empty`.
    Raises RegionError for a file whose regions are broken."""
    solution = (SOLUTION / name).read_text(encoding="utf-8")
    text = student_text
    for number, region in regions(student_text).items():
        if number in left_empty:
            text = replaced(text, number, template_body(region))
        elif number not in judged:
            text = replaced(text, number, body(solution, number))
    return Variant(name, text, tuple(judged), regions(student_text))
