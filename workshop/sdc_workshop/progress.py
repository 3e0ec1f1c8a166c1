"""The last answer about each step, and the attempts, in the package that the student writes."""

from __future__ import annotations

import contextlib
import json
import zlib
from pathlib import Path

from sdc_workshop.exam.answer import WRONG
from sdc_workshop.steps import LABS, WORKSHOP, load_steps
from sdc_workshop.workspace import package_of

NAME = ".progress.json"
# Key of the attempts: by step id, their number, and the checksum of the file at the last of them.
_ATTEMPTS = "attempts"


def statuses(folder: Path, lab: str = WORKSHOP) -> dict:
    """Return the status of each step of a lab when it was last checked, by step id."""
    return {key: value for key, value in _kept(folder, lab).items() if key != _ATTEMPTS}


def attempts(folder: Path, lab: str = WORKSHOP) -> dict:
    """Return how often each step was wrong, by step id; a file counts again when it has changed."""
    return {step_id: row[0] for step_id, row in _kept(folder, lab).get(_ATTEMPTS, {}).items()}


def keep(folder: Path, answers: dict) -> None:
    """Keep the answers of a check, by step id, and count the attempts."""
    for lab in (WORKSHOP, *LABS):
        steps = [step for step in load_steps(lab, optional=True) if step.id in answers]
        old = _kept(folder, lab)
        tries = old.get(_ATTEMPTS, {})
        for step in (one for one in steps if one.file and answers[one.id].status == WRONG):
            count, last = tries.get(step.id, (0, None))
            # A package that is not there, or cannot be written, is checked all the same.
            with contextlib.suppress(OSError):
                now = zlib.crc32((folder / "src" / str(step.file)).read_bytes())
                tries[step.id] = (count + (now != last), now)
        new = {step.id: answers[step.id].status for step in steps}
        with contextlib.suppress(OSError):
            if new:
                text = json.dumps({**old, **new, _ATTEMPTS: tries}, indent=1)
                (folder / "src" / package_of(lab) / NAME).write_text(text, encoding="utf-8")


def _kept(folder: Path, lab: str) -> dict:
    with contextlib.suppress(OSError, ValueError):
        text = (folder / "src" / package_of(lab) / NAME).read_text(encoding="utf-8")
        return dict(json.loads(text))
    return {}
