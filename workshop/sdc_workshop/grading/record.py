"""What is known about a check while it runs: answers, the step at work, and what was contained."""

from __future__ import annotations

import contextlib
import csv
import json
import re
import threading
from pathlib import Path
from typing import Iterable

from sdc_sim.report.writer import write_json

ANSWERS = "answers.json"
STATE = "check.json"
BUILD_LOG = "build.log"
NO_SANDBOX = "none"
# Environment variable with the secret of the class, for the check of one workspace.
SECRET = "SDC_WORKSHOP_SECRET"
# More events of a step than these are dropped: that many with a path, which a program can invent
# by its output, and that many without.
_MAX_EVENTS = 40


def printable(text: str) -> str:
    """Return a text in which line ends and other control characters are escaped.

    The name of a file may have them: it must neither write a line of the table nor move the cursor.
    """
    return "".join(one if one.isprintable() else ascii(one)[1:-1] for one in text)


class Record:
    """Writes files into the folder `result`, which no program of a student can write."""

    def __init__(self, result: Path):
        self.result = result
        self._lock = threading.Lock()
        self._answers: dict = {}
        self._state: dict = {"step": "", "notes": [], "contained": []}

    def begin(self, step: str) -> None:
        """Record what is checked from now on."""
        with self._lock:
            self._state["step"] = step
            write_json(self.result / STATE, self._state)

    def note(self, text: str) -> None:
        """Record what went wrong with the check itself."""
        with self._lock:
            self._state["notes"].append(text)
            write_json(self.result / STATE, self._state)

    def contained(self, text: str, path: str = "") -> None:
        """Record what the sandbox has kept a program from, and the file that it is about, or ""."""
        with self._lock:
            step, events = self._state["step"], self._state["contained"]
            event = [step, text, path]
            alike = [one for one in events if (one[0], one[2] == "") == (step, path == "")]
            if event not in alike and len(alike) < _MAX_EVENTS:
                events.append(event)
                write_json(self.result / STATE, self._state)

    def answer(self, step_id: str, answer: dict) -> None:
        """Record an answer."""
        with self._lock:
            self._answers[step_id] = answer
            write_json(self.result / ANSWERS, self._answers)


def write_table(path: Path, columns: Iterable[str], rows: Iterable[dict]) -> None:
    """Write a CSV; a column that a row does not have is empty, and other keys are left out."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(columns), extrasaction="ignore")
        table.writeheader()
        table.writerows({key: _cell(value) for key, value in row.items()} for row in rows)


def _cell(value: object) -> str:
    """Return the text of a cell, of which no spreadsheet makes a formula."""
    text = printable(str(value))
    is_number = re.fullmatch(r"[-+][\d.]*(e[-+]?\d+)?", text)
    return f"'{text}" if text[:1] in tuple("=+-@") and not is_number else text


def read(result: Path) -> tuple:
    """Return the answers by step id, and the state of a check, as far as they were written."""
    found: dict = {ANSWERS: {}, STATE: {"step": "", "notes": [], "contained": []}}
    for name in found:
        with contextlib.suppress(OSError, ValueError):
            found[name] = json.loads((result / name).read_text(encoding="utf-8"))
    return found[ANSWERS], found[STATE]
