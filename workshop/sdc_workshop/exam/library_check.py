"""Check the library: call functions as checks.yaml lists them, and compare with the solution.

The student's module runs in its own process: a loop may never end. Of a table with `asked`, only
the functions with these names run there; the world around them is out of the student's reach.
"""

from __future__ import annotations

import contextlib
import traceback
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, Iterator

import numpy as np

from sdc_workshop.exam import families
from sdc_workshop.exam.answer import IN_FULL, Problem, in_full, listed
from sdc_workshop.exam.asked import Asked, NoAnswer, Remote
from sdc_workshop.exam.output import last_line
from sdc_workshop.exam.probes import library_probe
from sdc_workshop.exam.process import NotJudged
from sdc_workshop.exam.region_check import RegionCheck
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import solution

_TOLERANCE = 1e-6
# A matrix with so many numbers is not printed: the first number that differs is.
_LARGE = 20
# What an expression may raise about a result of a student, which has any type and shape.
_ERRORS = (
    ArithmeticError,
    AttributeError,
    LookupError,
    TypeError,
    ValueError,
    np.linalg.LinAlgError,
)


class LibraryCheck(RegionCheck):
    """Checks a module of a library.

    Args:
        file: the module, relative to the src folder
        table: its entry of checks.yaml
    """

    def __init__(self, file: str, table: dict):
        self.file = file
        self.todos = tuple(dict.fromkeys(row["todo"] for row in table["rows"]))
        self._rows = table["rows"]
        self._laws = table.get("law", {})
        self._given = table.get("given", {})
        self._asked = table.get("asked", ())
        path = Path(file).with_suffix("")
        self._module = ".".join(path.parts[path.parts.index("src") + 1 :])

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See RegionCheck.problems."""
        path, python_path = stage.build(variant)
        given, calls = self._given, [row["call"] for row in self._rows]
        varied = {name: library_probe.varied(call, stage.seed) for name, call in given.items()}
        others = [library_probe.varied(call, stage.seed) for call in calls]
        with Asked(stage, self._module, stage.environment(PYTHONPATH=python_path)) as asked:
            wrong, broken = self._differences(asked, given, calls, path, variant)
            found: dict = {}
            for row, _, got, right, names in wrong:
                problem = None if row["todo"] in found else self._problem(row, got, right, names)
                if problem is not None:
                    sets = [(given, calls), (varied, others)]
                    found[row["todo"]] = self._explained(problem, row, asked, sets)
            if found or broken is not None:
                return [*found.values()] or [broken]
            wrong, broken = self._differences(asked, varied, others, path, variant)
        if broken is not None:
            return [broken]
        for row, call, got, right, _ in wrong[:1]:
            texts = {"got": _shown("value", got), "right": _shown("value", right)}
            texts["law"] = in_full(self._laws.get(row["todo"]))
            problem = listed("usual_arguments", row["todo"], call=call, **texts)
            stage.report(f"{variant.name}: {problem.seen}, as if they were written into it")
            return [problem]
        return []

    def _explained(self, problem: Problem, row: dict, asked: Asked, sets: list) -> Problem:
        """Return a problem with a hint that names the mistake, where only its law is known."""
        hint, _, law = problem.hint.partition(IN_FULL)
        if hint or self._asked:
            return problem
        rows = [other for other in self._rows if other["todo"] == row["todo"]]
        rows.sort(key=lambda other: other is not row)
        places = [self._rows.index(other) for other in rows]
        wanted = [(given, [calls[place] for place in places]) for given, calls in sets]

        def results() -> Iterator[Any]:
            for given, calls in wanted:
                names = library_probe.names_for(self._module, given, {})
                for call in calls:
                    yield library_probe.plain(library_probe.evaluate(call, names))

        got: list = []
        # What the student's lines return for other numbers may be an exception.
        with contextlib.suppress(NoAnswer, *_ERRORS):
            for given, calls in wanted:
                asked.begin(given)
                before = asked.ask("digests(globals(), wanted)", wanted=[*given])
                for call in calls:
                    got.append(asked.ask(f"plain({call})"))
                if asked.ask("digests(globals(), wanted)", wanted=[*given]) != before:
                    return replace(problem, hint=f"{families.CHANGED} {problem.hint}")
        text = solution(self.file).read_text(encoding="utf-8")
        known = text, row["todo"], self._module, results, got, same
        hint = families.sentence(*known) if got else ""
        return replace(problem, hint=f"{hint or families.UNKNOWN} {in_full(law)}".strip())

    def _differences(
        self, asked: Asked, given: dict, calls: list, path: Path, variant: Variant
    ) -> tuple[list, Problem | None]:
        """Return what is wrong: (row, call, result, right result, names); and what ended it."""
        found, broken = self._answers(asked, given, calls, path, variant)
        names = library_probe.names_for(self._module, given, {})
        rights = [library_probe.plain(library_probe.evaluate(call, names)) for call in calls]
        rows = zip(self._rows, calls, found, rights)
        return [(*row, names) for row in rows if not same(row[2], row[3])], broken

    def _answers(
        self, asked: Asked, given: dict, calls: list, path: Path, variant: Variant
    ) -> tuple[list, Problem | None]:
        """Return the results of calls, and why they end before the last, or None."""
        found: list = []
        try:
            evaluated = self._evaluated(asked, given)
            for call in calls:
                found.append(evaluated(call))
            return found, None
        except NoAnswer as error:
            if str(error):
                hint = "Is there a loop that never ends?"
                return found, Problem("a result", str(error), hint)
            output = asked.program.output
        except NotJudged:
            raise
        except Exception:  # noqa: BLE001  what a student's function returns may cause any
            output = traceback.format_exc()
        hint = (
            "The last line of its output gives the cause. exit() and quit() end the whole program. "
            "The check prints its results itself."
        )
        seen = f"it ends without one: {last_line(output)}"
        broken = self.exception_problem(output, path, variant)
        return found, broken or Problem("a result", seen, hint)

    def _evaluated(self, asked: Asked, given: dict) -> Callable[[str], Any]:
        """Return what evaluates a call: in the student's process, or here with what is asked."""
        if not self._asked:
            asked.begin(given)
            return lambda call: asked.ask(f"plain({call})")
        asked.begin({})
        remote = {name: Remote(asked, name) for name in self._asked}
        names = library_probe.names_for(self._module, given, remote)
        return lambda call: library_probe.plain(library_probe.evaluate(call, names))

    def _problem(self, row: dict, got: Any, right: Any, names: dict) -> Problem | None:
        """Return the problem of a wrong result; None where it is that of another row."""
        law = in_full(row.get("law", self._laws.get(row["todo"])))
        names = {**names, "got": got, "right": _array(right)}
        hint = next((hint for case, hint in row.get("wrong", ()) if _is_case(case, names)), law)
        if not hint:
            return None
        shows = [str(row.get("show", "value")), "value"]
        # More digits where a result differs from the right one by less than the usual ones show.
        texts = [
            [_shown(show, value, digits) for value in (right, got)]
            for digits in (3, 9)
            for show in shows
        ]
        shapes = [np.array(value, object).shape for value in (right, got)]
        texts.append([f"numbers of the shape {shape}" for shape in shapes])
        right_text, got_text = next((pair for pair in texts if pair[0] != pair[1]), texts[1])
        if "show" not in row:
            right_text, got_text = _first_difference(right, got) or (right_text, got_text)
        expected = row["expected"].replace("{right}", right_text)
        seen = row.get("seen", "{got}").replace("{got}", got_text or "nothing")
        return Problem(expected, seen, hint.replace("{law}", law), row["todo"])


def _array(value: Any) -> Any:
    """Return lists of numbers as an array, and all else as it is."""
    with contextlib.suppress(ValueError, TypeError):
        return np.array(value) if isinstance(value, list) else value
    return value


def _is_case(case: str, names: dict) -> bool:
    """Return whether a condition holds, or a typical wrong result is the one that was got."""
    try:
        value = library_probe.evaluate(case, names)
    except _ERRORS:
        return False
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    return same(names["got"], library_probe.plain(value))


def _shown(show: str, value: Any, digits: int = 3) -> str:
    """Return what `show` selects of a value as text; the whole value where it selects nothing."""
    with contextlib.suppress(*_ERRORS):
        value = library_probe.evaluate(show, {**library_probe.HELPERS, "value": value})
    numbers = library_probe.plain(value)
    rows = numbers if isinstance(numbers, list) else [numbers]
    flat = np.ravel(rows).tolist() if len({np.shape(row) for row in rows}) == 1 else rows
    text = ", ".join(f"{one:.{digits}f}" if isinstance(one, float) else str(one) for one in flat)
    return text.replace("nan", "NaN")[:300]


def _first_difference(right: Any, got: Any) -> list | None:
    """Return both texts of the first number that differs in two large matrices, or None."""
    try:
        matrices = [np.array(value, float) for value in (right, got)]
    except (TypeError, ValueError):
        return None
    if matrices[0].ndim != 2 or matrices[0].size < _LARGE:
        return None
    shapes = ["{} x {} numbers".format(*matrix.shape) for matrix in matrices if matrix.ndim == 2]
    if matrices[0].shape != matrices[1].shape:
        return shapes if len(shapes) == 2 else None
    close = np.isclose(*matrices, 0.1 * _TOLERANCE, 0.1 * _TOLERANCE, equal_nan=True)
    row, column = np.argwhere(~close)[0]
    place = f"{shapes[0]}, in row {row + 1}, column {column + 1}"
    return [f"{place}: {matrix[row, column]:.4g}" for matrix in matrices]


def same(got: object, wanted: object) -> bool:
    """Return whether two results are equal but for rounding."""
    if isinstance(wanted, list):
        return isinstance(got, list) and len(got) == len(wanted) and all(map(same, got, wanted))
    if not isinstance(got, (int, float)) or not isinstance(wanted, (int, float)):
        return got == wanted
    # NumPy's single precision is right, too.
    tolerance = _TOLERANCE * max(1.0, abs(wanted))
    return abs(got - wanted) < tolerance or (got != got and wanted != wanted)
