"""The last answer about each step, which is kept in the package that the student writes."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path

from sdc_workshop.steps import LABS, WORKSHOP, load_steps
from sdc_workshop.workspace import package_of

NAME = ".progress.json"


def statuses(folder: Path, lab: str = WORKSHOP) -> dict:
    """Return the status of each step of a lab when it was last checked, by step id."""
    with contextlib.suppress(OSError, ValueError):
        text = (folder / "src" / package_of(lab) / NAME).read_text(encoding="utf-8")
        return dict(json.loads(text))
    return {}


def keep(folder: Path, answers: dict) -> None:
    """Keep the answers of a check, by step id."""
    for lab in (WORKSHOP, *LABS):
        steps = load_steps(lab, optional=True)
        new = {one.id: answers[one.id].status for one in steps if one.id in answers}
        # A package that is not there, or cannot be written, is checked all the same.
        with contextlib.suppress(OSError):
            if new:
                text = json.dumps({**statuses(folder, lab), **new}, indent=1)
                (folder / "src" / package_of(lab) / NAME).write_text(text, encoding="utf-8")
