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
from sdc_workshop.exam.answer import IN_FULL, Answer, in_full, listed, mistake
from sdc_workshop.exam.asked import Asked, NoAnswer, Remote
from sdc_workshop.exam.families import TOLERANCE, same
from sdc_workshop.exam.output import last_line
from sdc_workshop.exam.probes import library_probe
from sdc_workshop.exam.process import NotJudged
from sdc_workshop.exam.region_check import RegionCheck
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.variant import Variant
from sdc_workshop.regions import body
from sdc_workshop.workspace import solution_text

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
    """Checks a module of a library, by its entry of checks.yaml."""

    def __init__(self, file: str, table: dict):
        self.file = file
        self.todos = tuple(dict.fromkeys(row["todo"] for row in table["rows"]))
        self._rows = table["rows"]
        self._laws = table.get("law", {})
        self._given = table.get("given", {})
        self._asked = table.get("asked", ())
        self.waits_for = "it is tried in single scenes, then in drives" if self._asked else ""
        path = Path(file).with_suffix("")
        self._module = ".".join(path.parts[path.parts.index("src") + 1 :])

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See RegionCheck.problems."""
        path, python_path = stage.build(variant)
        usual = self._given, [row["call"] for row in self._rows]
        varied = (
            {name: library_probe.varied(call, stage.seed) for name, call in self._given.items()},
            [library_probe.varied(call, stage.seed) for call in usual[1]],
        )
        with Asked(stage, self._module, stage.environment(PYTHONPATH=python_path)) as asked:
            for sets in ((usual, varied), (varied, usual)):
                wrong, broken = self._first_wrong(asked, *sets[0], path, variant)
                if wrong or broken is not None:
                    found = [self._explained(*known, asked, sets, variant) for known in wrong]
                    for problem in found if sets[0] is varied else ():
                        stage.report(f"{variant.name}: {problem.seen}, as if written into it")
                    return found or [broken]
        return []

    def _first_wrong(
        self, asked: Asked, given: dict, calls: list, path: Path, variant: Variant
    ) -> tuple[list, Answer | None]:
        """Return what is wrong first in each TODO, and why the calls end before the last, or None.

        Each is (problem, whether its hint is sure, results by the number of their row).
        """
        wrong: dict = {}
        results: dict = {}
        try:
            evaluated = self._evaluated(asked, given)
            names = library_probe.names_for(self._module, given, {})
            for number, (row, call) in enumerate(zip(self._rows, calls)):
                if row["todo"] in wrong:  # further rows may be drives, which take seconds
                    continue
                got = evaluated(call)
                right = library_probe.plain(library_probe.evaluate(call, names))
                results = {number: got, **results}
                if same(got, right):
                    continue
                if given is self._given:
                    found = self._problem(row, got, right, names)
                else:
                    found = self._of_usual_arguments(row["todo"], call, got, right), False
                if found is not None:
                    wrong[row["todo"]] = *found, results
        except NotJudged:
            raise
        except Exception as error:  # noqa: BLE001  what a student's function returns may cause any
            return [*wrong.values()], self._broken(error, asked, path, variant)
        return [*wrong.values()], None

    def _broken(self, error: Exception, asked: Asked, path: Path, variant: Variant) -> Answer:
        """Return the problem of a call without a result."""
        if isinstance(error, NoAnswer) and str(error):
            return mistake("a result", str(error), "Is there a loop that never ends?")
        output = traceback.format_exc()
        if isinstance(error, NoAnswer):
            output = asked.program.output
        hint = (
            "The last line of its output gives the cause. exit() and quit() end the whole program. "
            "The check prints its results itself."
        )
        seen = f"it ends without one: {last_line(output)}"
        return self.exception_problem(output, path, variant) or mistake("a result", seen, hint)

    def _of_usual_arguments(self, todo: str, call: str, got: Any, right: Any) -> Answer:
        texts = {"got": _shown("value", got), "right": _shown("value", right)}
        law = in_full(self._laws.get(todo))
        return listed("usual_arguments", todo=todo, call=call, law=law, **texts)

    def _explained(
        self,
        problem: Answer,
        is_sure: bool,
        received: dict,
        asked: Asked,
        sets: tuple,
        variant: Variant,
    ) -> Answer:
        """Return a problem whose hint names the mistake, where the table is not sure of it."""
        hint, _, law = problem.hint.partition(IN_FULL)
        # What a student designs is not our solution with a mistake.
        if is_sure or hint and self._asked:
            return problem
        numbers = [number for number in received if self._rows[number]["todo"] == problem.todo]
        got: list = []
        if self._asked:
            # Their rows can be drives: what was received is enough.
            sets, got = sets[:1], [received[number] for number in numbers]
        else:
            others = [n for n, row in enumerate(self._rows) if row["todo"] == problem.todo]
            numbers = [*dict.fromkeys(numbers + others)]
        wanted = [(given, [calls[number] for number in numbers]) for given, calls in sets]

        def results() -> Iterator[Any]:
            for given, calls in wanted:
                names = library_probe.names_for(self._module, given, {})
                for call in calls:
                    yield library_probe.plain(library_probe.evaluate(call, names))

        # What the student's lines return for other numbers may be an exception.
        with contextlib.suppress(NoAnswer, *_ERRORS):
            for given, calls in () if self._asked else wanted:
                asked.begin(given)
                names = library_probe.names_for(self._module, given, {})
                before = [self._digests(asked, given), library_probe.digests(names, [*given])]
                for call in calls:
                    got.append(asked.ask(f"plain({call})"))
                    library_probe.evaluate(call, names)
                after = [self._digests(asked, given), library_probe.digests(names, [*given])]
                mine, ours = ([a != b for a, b in zip(*pair)] for pair in zip(before, after))
                # What the solution changes, too, is the state of an object.
                if any(changed and not allowed for changed, allowed in zip(mine, ours)):
                    return replace(problem, hint=f"{families.CHANGED} {problem.hint}")
        todo = str(problem.todo)
        known = solution_text(self.file), todo, self._module, results, got
        named = families.sentence(*known, body(variant.text, todo), must_be_sure=bool(hint))
        hint = f"{named} {hint}".strip() or families.shape_sentence(results, got)
        hint = hint or families.UNKNOWN
        return replace(problem, hint=f"{hint} {in_full(law)}".strip())

    @staticmethod
    def _digests(asked: Asked, given: dict) -> list:
        return asked.ask("digests(globals(), wanted)", wanted=[*given])

    def _evaluated(self, asked: Asked, given: dict) -> Callable[[str], Any]:
        """Return what evaluates a call: in the student's process, or here with what is asked."""
        if not self._asked:
            asked.begin(given)
            return lambda call: asked.ask(f"plain({call})")
        asked.begin({})
        remote = {name: Remote(asked, name) for name in self._asked}
        names = library_probe.names_for(self._module, given, remote)
        return lambda call: library_probe.plain(library_probe.evaluate(call, names))

    def _problem(self, row: dict, got: Any, right: Any, names: dict) -> tuple | None:
        """Return the problem of a wrong result, and whether its hint is sure.

        It is sure where the result is a typical one, not where a condition holds. None where the
        problem is that of another row.
        """
        law = in_full(row.get("law", self._laws.get(row["todo"])))
        names.update(got=got, right=_array(right))
        cases = ((hint, _is_case(case, names)) for case, hint in row.get("wrong", ()))
        hint, how = next((case for case in cases if case[1]), (law, ""))
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
        problem = mistake(expected, seen, hint.replace("{law}", law), row["todo"])
        return problem, how == "equal"


def _array(value: Any) -> Any:
    """Return lists of numbers as an array, and all else as it is."""
    with contextlib.suppress(ValueError, TypeError):
        return np.array(value) if isinstance(value, list) else value
    return value


def _is_case(case: str, names: dict) -> str:
    """Return "equal" for the typical wrong result that was got, "holds" for a condition, or ""."""
    try:
        value = library_probe.evaluate(case, names)
    except _ERRORS:
        return ""
    if isinstance(value, (bool, np.bool_)):
        return "holds" if value else ""
    return "equal" if same(names["got"], library_probe.plain(value)) else ""


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
    close = np.isclose(*matrices, 0.1 * TOLERANCE, 0.1 * TOLERANCE, equal_nan=True)
    row, column = np.argwhere(~close)[0]
    place = f"{shapes[0]}, in row {row + 1}, column {column + 1}"
    return [f"{place}: {matrix[row, column]:.4g}" for matrix in matrices]
