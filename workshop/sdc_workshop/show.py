"""Shows on a terminal how the steps are: a progress bar, a tick or a cross a step, and what is to be said about the first cross."""

from __future__ import annotations

import shutil
import textwrap

from sdc_workshop.exam.answer import PASSED, UNFINISHED, WAITING, WRONG, Answer

_BAR = 40
_SIGNS = {PASSED: ("✓", "32"), WRONG: ("✗", "31"), UNFINISHED: ("·", "33"), WAITING: ("○", "33")}
_PLAIN_SIGNS = {PASSED: "+", WRONG: "x", UNFINISHED: ".", WAITING: "o"}
_WORDS = {
    WRONG: "is not right yet",
    UNFINISHED: "is not written yet",
    WAITING: "cannot be checked yet",
}


class Show:
    """Writes to `stream`: in colour where that is a terminal, and without special characters where it knows none."""

    def __init__(self, stream):
        self._stream = stream
        self._colour = stream.isatty()
        try:
            "✓█".encode(stream.encoding or "ascii")
            self._plain = False
        except UnicodeEncodeError:
            self._plain = True
        self._group = None

    def clear(self) -> None:
        """An empty screen, where there is one."""
        if self._colour:
            self._write("\x1b[2J\x1b[H")

    def begin(self, folder, steps) -> None:
        self._line(f"{folder}: {len(steps)} step{'s' if len(steps) != 1 else ''}")

    def step(self, step, answer: Answer) -> None:
        """One line about a step."""
        sign, colour = _SIGNS[answer.status]
        note = {WAITING: "   (waits)", UNFINISHED: "   (to be written)"}.get(answer.status, "")
        self._line(
            f" {self._coloured(_PLAIN_SIGNS[answer.status] if self._plain else sign, colour)} {step.id:22} {step.title}{note}"
        )

    def end(self, steps, answers: dict, everything: bool) -> None:
        """The bar, and the first step that is not passed in full: a wrong one before one that nobody has begun."""
        done = sum(answer.status == PASSED for answer in answers.values())
        filled = round(_BAR * done / len(steps))
        full, empty = ("#", "-") if self._plain else ("█", "░")
        self._line(
            f"\n[{self._coloured(full * filled, '32')}{empty * (_BAR - filled)}] {done} of {len(steps)}"
        )
        first = first_open(steps, answers)
        if first is None:
            if everything:
                self._line("\nAll steps are right. You have written a self-driving car.")
            return
        answer = answers[first.id]
        self._line(f"\n{self._coloured(first.id, '1')}: {first.title}: {_WORDS[answer.status]}.")
        self._field("expected", answer.expected)
        self._field("seen", answer.seen)
        self._field("where", answer.where)
        self._field("hint", answer.hint)
        self._line(
            f"\nMore: ./workshop/check --hint {first.id}    Only this one: ./workshop/check {first.id}    Write it for me: "
            f"./workshop/check --solution {first.id}"
        )

    def _field(self, name, text) -> None:
        if not text:
            return
        width = max(40, min(shutil.get_terminal_size((120, 24)).columns, 120) - 12)
        # A place is left whole: terminals and editors open it by a click.
        lines = (
            [text]
            if name == "where"
            else textwrap.wrap(text, width, break_long_words=False, break_on_hyphens=False)
        )
        for number, line in enumerate(lines):
            self._line(f"  {(name if number == 0 else ''):9} {line}")

    def _coloured(self, text, code) -> str:
        return f"\x1b[{code}m{text}\x1b[0m" if self._colour and text else text

    def _line(self, text) -> None:
        self._write(text + "\n")

    def _write(self, text) -> None:
        encoding = self._stream.encoding or "utf-8"
        self._stream.write(text.encode(encoding, errors="replace").decode(encoding))
        self._stream.flush()


def first_open(steps, answers: dict):
    """The first step that is wrong; without one, the first that is not passed; None when all are."""
    for wanted in ((WRONG,), (UNFINISHED, WAITING)):
        for step in steps:
            if step.id in answers and answers[step.id].status in wanted:
                return step
    return None
