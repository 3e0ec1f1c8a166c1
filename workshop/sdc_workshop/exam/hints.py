"""The hints of hints.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import yaml

from sdc_workshop.steps import STEPS_FILE


@dataclass(frozen=True)
class Hint:
    """The hint of a step, and further help for `./workshop/check --hint`."""

    hint: str
    more: str


@lru_cache(maxsize=1)
def _all() -> dict:
    return yaml.safe_load(STEPS_FILE.with_name("hints.yaml").read_text(encoding="utf-8"))


def hint_of(step_id: str) -> Hint:
    """Return the hint of a step."""
    return Hint(**_all()[step_id])
