"""Show the answers of a check: one line a step, a progress bar, and details of one open step."""

from __future__ import annotations

import shutil
import textwrap
from pathlib import Path
from typing import TextIO

from sdc_workshop.exam.answer import IN_FULL, NOT_JUDGED, PASSED, UNFINISHED, WAITING, WRONG, Answer
from sdc_workshop.steps import Step, load_steps

_BAR = 40
# With this attempt, a hint also gives the line or the formula.
_FULL_ATTEMPT = 3
# Of each status: the sign, the same in ASCII, the colour, a note, and a sentence.
_SIGNS = {
    PASSED: ("✓", "+", "32", "", ""),
    WRONG: ("✗", "x", "31", "", "is not right yet"),
    UNFINISHED: ("·", ".", "33", "   (to be written)", "is not written yet"),
    WAITING: ("○", "o", "33", "   (waits)", "cannot be checked yet"),
    NOT_JUDGED: ("?", "?", "33", "", "was not judged"),
}


class Show:
    """Prints answers to a stream: in colour on a terminal, in ASCII where the encoding needs it."""

    def __init__(self, stream: TextIO):
        self._stream = stream
        self._colour = stream.isatty()
        self._waits = False
        try:
            "✓█".encode(stream.encoding or "ascii")
            self._plain = False
        except UnicodeEncodeError:
            self._plain = True

    def clear(self) -> None:
        """Clear the screen of a terminal."""
        if self._colour:
            self._write("\x1b[2J\x1b[H")

    def begin(self, folder: Path, steps: list) -> None:
        """Print which workspace is checked."""
        self._line(f"{folder}: {len(steps)} step{'s' if len(steps) != 1 else ''}")

    def waits(self, step: Step, what: str) -> None:
        """Show on a terminal what the check of a step waits for; the next line replaces it."""
        if self._colour and what:
            self._write(f" ... {step.id:20} {what}\r")
            self._waits = True

    def step(self, step: Step, answer: Answer) -> None:
        """Print one line about a step."""
        sign, plain, colour, note, _ = _SIGNS[answer.status]
        sign = self._coloured(plain if self._plain else sign, colour)
        self._line(f" {sign} {step.id:22} {step.title}{note}")
        if answer.status == PASSED:
            # An experiment has a result that is worth reading.
            self._field("predicted", answer.expected)
            self._field("measured", answer.seen)
            self._field("why", answer.hint)

    def end(self, steps: list, answers: dict, kept: dict, attempts: dict) -> None:
        """Print the progress bar, and details of the step to work on next.

        By step id: the answers, what was kept of all steps of the lesson, and the attempts.
        """
        lesson = load_steps(steps[0].lab)
        everything = steps == lesson
        self._line("")
        for phase in sorted({step.phase for step in lesson}) if everything else ():
            self._bar([step for step in steps if step.phase == phase], answers, f"phase {phase}  ")
        self._bar(steps, answers, "all      " if everything else "")
        if not everything:
            right = sum(kept.get(step.id) == PASSED for step in lesson)
            self._line(f"{right} of {len(lesson)} steps of the lesson are right by now.")
        first = first_open(steps, {step_id: one.status for step_id, one in answers.items()})
        if first is None:
            if everything:
                written = "" if steps[0].lab else " You have written a self-driving car."
                self._line(f"\nAll steps are right.{written}")
                if load_steps(steps[0].lab, optional=True) != lesson:
                    self._line("Next, if you like: the experiments of phase 4 of the guide.")
            return
        answer = answers[first.id]
        self._line(
            f"\n{self._coloured(first.id, '1')}: {first.title}: {_SIGNS[answer.status][-1]}."
        )
        self._field("expected", answer.expected)
        self._field("seen", answer.seen)
        self._field("where", answer.where)
        self._field("hint", self._hint(answer, attempts.get(first.id, 0), first.id))
        if answer.seed:
            self._field("repeat", f"./workshop/check --seed {answer.seed} {first.id}")
        self._line(
            f"\nMore: ./workshop/check --hint {first.id}    "
            f"Only this one: ./workshop/check {first.id}    "
            f"Write it for me: ./workshop/check --solution {first.id}"
        )

    @staticmethod
    def _hint(answer: Answer, attempt: int, step_id: str) -> str:
        """Return the hint; before the third attempt, without what gives the line away."""
        hint, full, _ = answer.hint.partition(IN_FULL)
        if not full or (answer.status == WRONG and attempt >= _FULL_ATTEMPT):
            return answer.hint
        more = f"`./workshop/check --hint {step_id}` says more."
        if answer.status != WRONG:
            return f"{hint}The page says what must come out; {more}"
        count = f"attempt {attempt}; attempt {_FULL_ATTEMPT} shows the line or the formula"
        return f"{hint}(This is {count}, and {more})"

    def _bar(self, steps: list, answers: dict, name: str) -> None:
        done = sum(step.id in answers and answers[step.id].status == PASSED for step in steps)
        filled = round(_BAR * done / len(steps))
        full, empty = ("#", "-") if self._plain else ("█", "░")
        bar = self._coloured(full * filled, "32") + empty * (_BAR - filled)
        self._line(f"{name}[{bar}] {done} of {len(steps)}")

    def _field(self, name: str, text: str) -> None:
        if not text:
            return
        width = max(40, min(shutil.get_terminal_size((120, 24)).columns, 120) - 12)
        lines = [text]
        # A place is not wrapped: terminals and editors open it by a click.
        if name != "where":
            lines = textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False)
        for number, line in enumerate(lines):
            self._line(f"  {(name if number == 0 else ''):9} {line}")

    def _coloured(self, text: str, code: str) -> str:
        return f"\x1b[{code}m{text}\x1b[0m" if self._colour and text else text

    def _line(self, text: str) -> None:
        self._write(text + "\n")

    def _write(self, text: str) -> None:
        if self._waits:
            text, self._waits = f"\x1b[K{text}", False
        encoding = self._stream.encoding or "utf-8"
        self._stream.write(text.encode(encoding, errors="replace").decode(encoding))
        self._stream.flush()


def first_open(steps: list, statuses: dict) -> Step | None:
    """Return the first wrong step; without one, the first that is not passed; else None."""
    for wanted in ((WRONG,), (UNFINISHED, WAITING, NOT_JUDGED)):
        for step in steps:
            if statuses.get(step.id) in wanted:
                return step
    return None
