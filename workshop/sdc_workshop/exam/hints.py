"""The hints of the hints.yaml of the workshop and of each lab."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import yaml

from sdc_workshop.steps import LABS, WORKSHOP, lesson_folder


@dataclass(frozen=True)
class Hint:
    """The hint of a step, and further help for `./workshop/check --hint`."""

    hint: str
    more: str


@lru_cache(maxsize=1)
def _all() -> dict:
    files = [lesson_folder(lab) / "hints.yaml" for lab in (WORKSHOP, *LABS)]
    found: dict = {}
    for path in files:
        found.update(yaml.safe_load(path.read_text(encoding="utf-8")))
    return found


def hint_of(step_id: str) -> Hint:
    """Return the hint of a step."""
    return Hint(**_all()[step_id])
