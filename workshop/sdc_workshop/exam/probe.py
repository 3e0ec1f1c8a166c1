"""Tries a variant of a library file in a process of its own: a student's loop may never end."""

from __future__ import annotations

import json
from pathlib import Path

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.output import crash, last_words, meaning
from sdc_workshop.exam.variant import Variant

_PROBE = Path(__file__).with_name("probes") / "library_probe.py"
_LIMIT_S = 60.0


def probe(variant: Variant, stage, name: str):
    """What library_probe.py finds out about module `name`, as a dictionary; a Problem when the module breaks or never answers."""
    path, python_path = stage.build(variant)
    with stage.program(
        ["/usr/bin/env", "python3", _PROBE, name], PYTHONPATH=python_path
    ) as program:
        how = program.wait_until(lambda: False, _LIMIT_S)
        if how != "ended":
            return Problem(
                "an answer",
                "it runs in circles and never answers",
                "Is there a loop that never ends?",
            )
        found = crash(program.output, path)
        if found is not None:
            shown = variant.text.split("\n")[found.line - 1].strip() if found.line else ""
            return Problem(
                f"{path.name} runs without an error",
                f"{found.error[:300]}{f', in `{shown}`' if shown else ''}",
                meaning(found),
                variant.region_of(found.line) if found.line else None,
                found.line,
                True,
            )
        if program.status != 0:
            return Problem("an answer", last_words(program.output), "Its last words say why.")
        return json.loads(program.output.splitlines()[-1])
