"""What a check says about a step."""

from __future__ import annotations

from dataclasses import asdict, dataclass

PASSED = "passed"
WRONG = "wrong"
UNFINISHED = "unfinished"  # nothing of the student's own is there yet
WAITING = "waiting"  # an earlier step must be mended before this one can be judged


@dataclass(frozen=True)
class Problem:
    """One thing that is not as it should be. `todo` is the number of the region that it is about, None where that is not known; `line`
    counts from 1 in the file that was examined, which is not always the student's."""

    expected: str
    seen: str
    hint: str
    todo: str | None = None
    line: int | None = None
    is_error: bool = False  # Python's own words; what they mean alone seldom says what belongs here


@dataclass(frozen=True)
class Answer:
    """The verdict on a step. `file` is relative to the workspace, `line` counts from 1."""

    status: str
    expected: str = ""
    seen: str = ""
    hint: str = ""
    file: str | None = None
    line: int | None = None

    @property
    def where(self) -> str:
        """For people and editors: "src/sdc_package/scripts/camera.py:20"."""
        return f"{self.file}:{self.line}" if self.file and self.line else self.file or ""

    def as_dict(self) -> dict:
        return asdict(self)


def wrong(problem: Problem, file: str | None = None, line: int | None = None) -> Answer:
    """A problem as the answer to the step whose fault it is."""
    return Answer(WRONG, problem.expected, problem.seen, problem.hint, file, line)
