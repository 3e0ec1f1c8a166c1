"""./workshop/check quiz [LESSON]: five questions about a lesson, with numbers drawn from a seed."""

from __future__ import annotations

import math
import random
import secrets
from pathlib import Path
from typing import NamedTuple

import yaml

from sdc_workshop import progress
from sdc_workshop.exam.answer import PASSED
from sdc_workshop.steps import FOLDER, StepError, load_steps
from sdc_workshop.workspace import WorkspaceError, find, lab_of

QUIZ = FOLDER / "quiz"
_MATHS = {name: getattr(math, name) for name in dir(math) if name[0] != "_"}
_MATHS.update(abs=abs, max=max, min=min, round=round)


class Question(NamedTuple):
    """A question whose numbers are drawn: a number is asked for, or the letter of a choice."""

    text: str
    choices: list  # in the order in which they are shown; empty: the answer is a number
    answer: float  # the number, or the place in `choices`
    tolerance: float
    unit: str
    why: str

    def value(self, typed: str) -> float | None:
        """Return the number, or the place of the choice, that was typed; None: neither."""
        if self.choices:
            place = "abcdefgh".find(typed.strip().lower() or "?")
            return place if 0 <= place < len(self.choices) else None
        try:
            return float(typed.strip().replace(",", "."))
        except ValueError:
            return None

    def is_right(self, value: float) -> bool:
        """Return whether a value is the answer, within the tolerance."""
        return abs(value - self.answer) <= self.tolerance

    def correction(self) -> str:
        """Return the sentence that gives the answer after a wrong one."""
        if self.choices:
            place = int(self.answer)
            return f"No, {'abcdefgh'[place]}: {self.choices[place]}."
        return f"No, it is {round(self.answer, 3):.10g} ({self.unit})."


def lessons() -> list:
    """Return the names of all lessons that have a quiz."""
    return sorted(path.stem for path in QUIZ.glob("*.yaml"))


def questions(lesson: str, seed: str) -> list:
    """Return the questions of a lesson, the same for the same seed."""
    rows = yaml.safe_load((QUIZ / f"{lesson}.yaml").read_text(encoding="utf-8"))
    return [_drawn(row, random.Random(f"{seed} {lesson} {n}")) for n, row in enumerate(rows)]


def _drawn(row: dict, rng: random.Random) -> Question:
    numbers = {name: rng.choice(values) for name, values in row.get("draw", {}).items()}
    # The files of the quizzes are a part of the project: an answer is an expression of its numbers.
    answer = eval(str(row.get("answer", 0)), {"__builtins__": {}}, {**_MATHS, **numbers})
    choices = [text.format(**numbers) for text in row.get("choices", [])]
    if choices:
        right = choices[answer]
        rng.shuffle(choices)
        answer = choices.index(right)
    why = row["why"].format(**numbers, answer=f"{round(answer, 3):.10g}")
    tolerance = 0.0 if choices else row["tolerance"]
    unit = row.get("unit", "")
    return Question(row["ask"].format(**numbers), choices, answer, tolerance, unit, why)


def default_lesson(folder: Path | None) -> str:
    """Return the lesson at which a student is; raises StepError without a workspace."""
    if folder is None:
        raise StepError(f"name a lesson: ./workshop/check quiz LESSON, of {', '.join(lessons())}")
    right = progress.statuses(folder)
    phases = (step.phase for step in load_steps() if right.get(step.id) != PASSED)
    return lab_of(folder) or f"phase-{next(phases, 4)}"


def run(lesson: str, seed: str, place: Path) -> int:
    """Ask the questions of a lesson on standard input; return the exit status.

    Without names, the lesson is that at which the student is, and the seed a new one. The result is
    kept in the workspace that contains the folder `place`, if one does.
    """
    try:
        folder: Path | None = find(place)
    except WorkspaceError:
        folder = None
    lesson = lesson or default_lesson(folder)
    seed = seed or secrets.token_hex(4)
    asked, right = questions(lesson, seed), 0
    print(f"{lesson}: {len(asked)} questions")
    for number, question in enumerate(asked, 1):
        print(f"\n{number}. {question.text}")
        for letter, text in zip("abcdefgh", question.choices):
            print(f"   {letter}: {text}")
        value, wanted = None, f"number ({question.unit})" if question.unit else "letter"
        while value is None:
            try:
                value = question.value(input(f"   {wanted}: "))
            except (EOFError, KeyboardInterrupt):
                print(f"\nThe quiz ended at question {number} of {len(asked)}; no result is kept.")
                return 1
        is_right = question.is_right(value)
        right += is_right
        print(f"   {'Right.' if is_right else question.correction()} {question.why}")
    if folder is not None and (folder / "src" / "sdc_package").is_dir():
        progress.keep_quiz(folder, lesson, right)
    print(f"\n{right} of {len(asked)} right.   Again: ./workshop/check --seed {seed} quiz {lesson}")
    return 0 if right == len(asked) else 1
