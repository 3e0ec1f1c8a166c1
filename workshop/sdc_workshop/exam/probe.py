"""Run a variant of a library file in its own process: a student's loop may never end."""

from __future__ import annotations

import json
import secrets
from pathlib import Path
from random import Random

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.output import crash, last_line, meaning
from sdc_workshop.exam.stage import NEVER_RETURNED, Stage
from sdc_workshop.exam.variant import Variant

_PROBE = Path(__file__).with_name("probes") / "library_probe.py"
_TIMEOUT_S = 60.0
_TOLERANCE = 1e-6


def probe(variant: Variant, stage: Stage, name: str) -> dict | Problem:
    """Return what library_probe.py finds about a module.

    Args:
        variant: the module's file
        stage: where it runs
        name: name of the probe

    Returns:
        the results, or a Problem when the module raises an exception or does not end
    """
    path, python_path = stage.build(variant)
    seed = secrets.token_hex(16)
    command = ["/usr/bin/env", "python3", _PROBE, name, seed]
    with stage.program(command, PYTHONPATH=python_path) as program:
        how = program.wait_until(lambda: False, _TIMEOUT_S)
        if how != "ended":
            stage.report(NEVER_RETURNED)
            return Problem("a result", "it never returns", "Is there a loop that never ends?")
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
            return Problem(
                "a result",
                last_line(program.output),
                "The last line of its output gives the cause.",
            )
        try:
            found = json.loads(program.output.splitlines()[-1])
            return {**found, "as_solved": same(found["other"], _solved(name, seed))}
        except (IndexError, KeyError, TypeError, ValueError):
            seen = last_line(program.output)
            return Problem("a result", seen, "The check prints its results itself, as the last.")


def _solved(name: str, seed: str) -> list:
    """Return the solution's results for the arguments of a seed, through JSON like a student's."""
    from sdc_workshop.exam.probes.library_probe import PROBES, plain

    return json.loads(json.dumps(PROBES[name](Random(seed)), default=plain))["other"]


def same(got: object, wanted: object) -> bool:
    """Return whether two numbers, or two lists of numbers, are equal but for rounding."""
    if isinstance(wanted, list):
        return isinstance(got, list) and len(got) == len(wanted) and all(map(same, got, wanted))
    if not isinstance(got, (int, float)) or not isinstance(wanted, (int, float)):
        return False
    return abs(got - wanted) < _TOLERANCE
