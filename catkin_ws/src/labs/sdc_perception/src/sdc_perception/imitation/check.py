"""Check the file of a student of the lab: python3 -m sdc_perception.imitation.check FILE."""

from __future__ import annotations

import runpy
import sys
from typing import Any

import numpy as np

from sdc_common.configuration import node_config

# What a call of a student's function may raise.
_ERRORS = (ArithmeticError, AttributeError, LookupError, NameError, TypeError, ValueError)


def problems(names: dict[str, Any]) -> dict[str, str]:
    """Return the first problem of each function of a student's file, "" where it is right."""
    found: dict[str, str] = {}
    for row in node_config("sdc_perception", "imitation_checks")["rows"]:
        name = row["call"].partition("(")[0]
        if name not in names:
            found[name] = "is not written yet"
        elif not found.get(name):
            found[name] = _problem(row, names)
    return found


def _problem(row: dict[str, Any], names: dict[str, Any]) -> str:
    try:
        got = np.asarray(eval(row["call"], names), float)
    except (*_ERRORS, RuntimeError) as error:
        return f"{row['call']}\n    {type(error).__name__}: {error}"
    if _same(got, row["expected"]):
        return ""
    hint = next((hint for value, hint in row["wrong"] if _same(got, value)), row["hint"])
    seen = np.round(got, 4).tolist()
    return f"{row['call']}\n    expected  {row['expected']}\n    seen      {seen}\n    {hint}"


def _same(got: np.ndarray, wanted: Any) -> bool:
    return got.shape == np.shape(wanted) and np.allclose(got, wanted, atol=1e-4)


def main() -> None:
    """Run the command."""
    found = problems(runpy.run_path(sys.argv[1]))
    for name, problem in found.items():
        print(f"{name}: {problem or 'right'}")
    sys.exit(int(any(found.values())))


if __name__ == "__main__":
    main()
