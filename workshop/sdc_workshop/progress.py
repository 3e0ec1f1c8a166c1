"""What a student's package keeps: answers, attempts and times of the steps, quizzes, own car."""

from __future__ import annotations

import contextlib
import json
import time
import zlib
from pathlib import Path

from sdc_sim.report.writer import write_json
from sdc_workshop.exam.answer import PASSED, WRONG
from sdc_workshop.steps import LABS, WORKSHOP, load_steps
from sdc_workshop.workspace import package_of

NAME = ".progress.json"
# Key of the attempts: by step id, their number, and the checksum of the file at the last of them.
_ATTEMPTS = "attempts"
# Key of the times: by step id, when it was first wrong or right, and first right [s since 1970].
_TIMES = "times"
# Key of the quizzes: by lesson, the number of right answers in the last one.
_QUIZ = "quiz"
# Key of the best score of the student's own car, 0 to 100.
_BEST_CAR = "my-car"


def statuses(folder: Path, lab: str = WORKSHOP) -> dict:
    """Return the status of each step of a lab when it was last checked, by step id."""
    other = (_ATTEMPTS, _TIMES, _QUIZ, _BEST_CAR)
    return {key: value for key, value in _kept(folder, lab).items() if key not in other}


def attempts(folder: Path, lab: str = WORKSHOP) -> dict:
    """Return how often each step was wrong, by step id; a file counts again when it has changed."""
    return {step_id: row[0] for step_id, row in _kept(folder, lab).get(_ATTEMPTS, {}).items()}


def times(folder: Path, lab: str = WORKSHOP) -> dict:
    """Return {"first": s, "passed": s} of each step that was tried, by step id."""
    return dict(_kept(folder, lab).get(_TIMES, {}))


def quizzes(folder: Path) -> dict:
    """Return the number of right answers in the last quiz about each lesson."""
    return dict(_kept(folder, WORKSHOP).get(_QUIZ, {}))


def keep_quiz(folder: Path, lesson: str, right: int) -> None:
    """Keep the result of a quiz."""
    kept = _kept(folder, WORKSHOP)
    _write(folder, WORKSHOP, {**kept, _QUIZ: {**kept.get(_QUIZ, {}), lesson: right}})


def best_car(folder: Path) -> float | None:
    """Return the best score of the student's own car, 0 to 100; None: it has not driven."""
    score = _kept(folder, WORKSHOP).get(_BEST_CAR)
    return None if score is None else float(score)


def keep_best_car(folder: Path, score: float) -> float:
    """Keep the score of the student's own car if it is better, and return the best one."""
    best = max(best_car(folder) or 0.0, score)
    _write(folder, WORKSHOP, {**_kept(folder, WORKSHOP), _BEST_CAR: best})
    return best


def keep(folder: Path, answers: dict) -> None:
    """Keep the answers of a check, by step id, count the attempts, and note the times."""
    for lab in (WORKSHOP, *LABS):
        steps = [step for step in load_steps(lab, optional=True) if step.id in answers]
        old = _kept(folder, lab)
        tries, stamps, now_s = old.get(_ATTEMPTS, {}), old.get(_TIMES, {}), round(time.time())
        for step in (one for one in steps if one.file and answers[one.id].status == WRONG):
            count, last = tries.get(step.id, (0, None))
            # A package that is not there, or cannot be written, is checked all the same.
            with contextlib.suppress(OSError):
                now = zlib.crc32((folder / "src" / str(step.file)).read_bytes())
                tries[step.id] = (count + (now != last), now)
        new = {step.id: answers[step.id].status for step in steps}
        for step_id in (key for key, status in new.items() if status in (PASSED, WRONG)):
            stamps.setdefault(step_id, {}).setdefault("first", now_s)
            if new[step_id] == PASSED:
                stamps[step_id].setdefault("passed", now_s)
        if new:
            _write(folder, lab, {**old, **new, _ATTEMPTS: tries, _TIMES: stamps})


def _write(folder: Path, lab: str, kept: dict) -> None:
    with contextlib.suppress(OSError):  # The page of a class never reads half a file.
        write_json(folder / "src" / package_of(lab) / NAME, kept)


def _kept(folder: Path, lab: str) -> dict:
    with contextlib.suppress(OSError, ValueError):
        text = (folder / "src" / package_of(lab) / NAME).read_text(encoding="utf-8")
        return dict(json.loads(text))
    return {}
