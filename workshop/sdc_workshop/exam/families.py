"""Name the mistake behind wrong results: make it in the solution, and compare the results.

A family changes a part of any solution: its sign, a factor, its place. Where the solution with such
a change returns what the student's lines return, in all calls of a check, this is the mistake.
"""

from __future__ import annotations

import ast
import contextlib
import copy
import importlib
import itertools
import math
import re
import time
import warnings
from functools import lru_cache
from pathlib import Path
from types import FunctionType
from typing import Any, Callable, Iterator

import numpy as np
import yaml

from sdc_workshop.regions import regions

# Name of the unknown number in families.yaml, which no solution uses.
_NUMBER = "_c"
# Name of the greatest of the student's numbers, at which a limit may cut the result.
_GREATEST = "_greatest"
# Name of NumPy in a changed solution, which may not import it.
_LIBRARY = "_np"
# A changed loop may never end: it ends after so many passes.
_PASSES = 10_000
_PASS = "_pass"
# Fewer results that are yes, no or whole numbers are equal by chance.
_FEW = 4
# Processor time for all changes of a region: most need much less, that of a drive more [s].
_MOST_CPU_S = 2.5
# The first numbers that are tried: the secant method begins with two.
_TRIALS = (1, 2)
# How often the number is improved: a result that is linear in it needs one step, others few.
_STEPS = 8
# Results with a smaller difference are equal.
TOLERANCE = 1e-6
# An error that is smaller is rounding.
_EXACT = 1e-7
# With a number that is by so much greater, the result must be another one.
_NEAR = 1e-3
# Another value of a part, for each value that is not -1.3717.
_MOVED = "1.001 * A + 0.0013717"
# A part of the solution that is at most so long is shown as it is.
_SHORT = 24

CHANGED = (
    "It changes an array that it gets: `-=`, `+=`, sort and the like write into the caller's array."
)
UNKNOWN = "No usual mistake gives this number: compute the example by hand, and print the parts."

Results = Callable[[], Iterator[Any]]


@lru_cache(maxsize=1)
def _tables() -> dict:
    path = Path(__file__).with_name("families.yaml")
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def sentence(
    text: str,
    todo: str,
    module: str,
    results: Results,
    got: list,
    written: str,
    must_be_sure: bool = False,
) -> str:
    """Return a sentence about the mistake in a region, or "".

    Args:
        text: the solution of the file
        todo: number of the region
        module: name of the module
        results: yields what the solution returns in each call, while it may be changed
        got: what the student's lines return in these calls; the first of them is wrong
        written: the student's lines, in which a sentence must not name what they do not have
        must_be_sure: whether all results must be equal, and more of them than a chance allows
    """
    # Many changes give the same yes and no, or the same whole numbers.
    shown = str([*_quiet(results)])
    is_vague = "." not in shown.replace(".0,", "").replace(".0]", "")
    if not got or is_vague and (len(got) < _FEW or len({*_flat(got)}) == 1):
        return ""
    must_be_sure = must_be_sure or is_vague
    end_s = time.process_time() + _MOST_CPU_S
    best, count, near = "", 0, ""
    for trial, places, said in _trials(text, todo, module, results, got):
        is_exact = said[0] in _tables()["exact"]
        if is_vague and is_exact or not _is_in(written, *said):
            continue
        kept = [container[key] for container, key, _ in places]
        _put(places)
        try:
            matches, number = trial.matches(any(_uses_number(new) for *_, new in places))
            container, key, new = places[0]
            is_effect = said[0] != _meaning(0) and not is_vague and _is_number(new)
            if is_effect and matches == len(got) and number is None:
                # Where the result is limited, many changes give the same.
                _put([(container, key, _made(_MOVED, {"A": new}))])
                if trial.matches(False)[0] == len(got):
                    near, matches = near or _filled([_tables()["near"], said[1]], None), 0
        finally:
            _put([(container, key, part) for (container, key, _), part in zip(places, kept)])
        is_plain = not is_exact
        if number is not None:
            meaning = _meaning(number, _source(kept[0], text))
            is_plain, said = meaning is not None, [said[0] or meaning or said[0], said[1]]
        if matches == len(got) and (number is None or is_plain):
            return f"{near} Or: {_filled(said, number)}" if near else _filled(said, number)
        if matches > count and (is_plain and 4 * matches >= 3 * len(got) or matches == len(got)):
            best, count = _filled(said, number), matches
        if time.process_time() > end_s:
            break
    return best if count == len(got) or best and not must_be_sure else near


def _is_in(written: str, text: str, names: dict) -> bool:
    """Return whether the student's lines have what the sentence of a change says that they have."""
    last = {key: "".join(re.findall(r"\w+", name)[-1:]) for key, name in names.items()}
    return bool(re.search(_tables()["needs"].get(text, "").format(**last), written))


def shape_sentence(results: Results, got: list) -> str:
    """Return a sentence about the form of a first result, such as its shape, or ""."""
    both = [*_quiet(results)], got
    shapes = [np.array(values[:1], object).shape[1:] for values in both]
    if shapes[0] != shapes[1]:
        return _tables()["shape" if shapes[0] else "pair"].format(*shapes)
    with contextlib.suppress(TypeError, ValueError):
        right, mine = (np.array(values[0], float) for values in both)
        wrong = ~np.isclose(mine, right, TOLERANCE, TOLERANCE)
        if right.ndim == 2 and (mine == np.diag(np.diag(mine))).all() and not np.diag(wrong).any():
            return _tables()["diagonal"]
        if np.allclose(*(np.sort(values, axis=None) for values in (mine, right))):
            return _tables()["order"]
        if wrong.sum() == 1 < right.size:
            return _tables()["one"].format(", ".join(map(str, np.argwhere(wrong)[0])))
    return ""


def _put(places: list) -> None:
    """Put each new part into its place."""
    for container, key, new in places:
        is_part = isinstance(new, ast.AST)
        container[key] = ast.fix_missing_locations(new) if is_part else new


def _trials(text: str, todo: str, module: str, *known: Any) -> Iterator[tuple]:
    """Yield (trial, places, sentence) of each change of a region; see _changes."""
    region = regions(text)[todo]
    tree = ast.parse(text)
    for owner in [tree, *(node for node in tree.body if isinstance(node, ast.ClassDef))]:
        place: Any = importlib.import_module(module)
        place = getattr(place, owner.name) if isinstance(owner, ast.ClassDef) else place
        for node in owner.body:
            function = vars(place).get(getattr(node, "name", ""))
            slots = _slots(node, region.first + 1, region.end)
            if isinstance(node, ast.FunctionDef) and isinstance(function, FunctionType) and slots:
                for loop in filter(lambda part: isinstance(part, ast.While), ast.walk(node)):
                    loop.body.append(ast.parse(f"next({_PASS})").body[0])
                trial = _Trial(function, node, *known)
                for change in _changes(node, slots, text):
                    yield (trial, *change)


class _Trial:
    """Runs a changed function in the place of the solution's: the caller changes its `node`."""

    def __init__(self, function: FunctionType, node: ast.AST, results: Results, got: list):
        self._function, self._node = function, node
        self._results, self._got = results, got
        sizes = (abs(number) for number in _flat(got))
        self._greatest = max((size for size in sizes if size < math.inf), default=0.0)

    def matches(self, has_number: bool) -> tuple:
        """Return in how many calls the results are equal, 0 if not in the first, and the number."""
        try:
            # A method needs a class around it: super() refers to it.
            owner = ast.parse("class owner: pass").body[0]
            owner.body = [self._node]
            made = compile(
                ast.Module([owner], []), "<family>", "exec", dont_inherit=True
            ).co_consts[0]
        except (SyntaxError, ValueError, TypeError):
            return 0, None
        name = self._function.__name__
        codes = [code for code in made.co_consts if getattr(code, "co_name", "") == name]
        kept, space = self._function.__code__, self._function.__globals__
        space.update({_LIBRARY: np, _GREATEST: self._greatest})
        try:
            self._function.__code__ = codes[0]
            number = self._number() if has_number else None
            if has_number and number is None:
                return 0, None
            space[_NUMBER] = number
            return self._equal(), number
        except ValueError:  # a closure of another size
            return 0, None
        finally:
            self._function.__code__ = kept

    def _equal(self) -> int:
        """Return the number of equal results, 0 where the first one is not."""
        count = 0
        self._function.__globals__[_PASS] = iter(range(_PASSES))
        for mine, theirs in zip(self._got, _quiet(self._results)):
            count += same(mine, theirs)
            if not count:
                return 0
        return count

    def _number(self) -> float | None:
        """Return the number with which the first call returns the student's result, or None."""
        errors = [self._errors(number) for number in _TRIALS]
        if errors[0] is None or errors[1] is None or errors[0].shape != errors[1].shape:
            return None
        if (errors[0] == errors[1]).all():
            return None
        place = int(np.flatnonzero(errors[0] != errors[1])[0])
        last, number = map(float, _TRIALS)
        before, error = errors[0][place], errors[1][place]
        for _ in range(_STEPS):  # the secant method
            if abs(error) < _EXACT:
                # Where the result is limited, many numbers give the same.
                near = self._errors(number + _NEAR)
                return None if near is not None and abs(near[place]) < _EXACT else number
            if error == before:
                return None
            last, number = number, number - error * (number - last) / (error - before)
            number = round(number) if abs(number - round(number)) < _EXACT else number
            found = self._errors(number)
            if found is None:
                return None
            before, error = error, found[place]
        return None

    def _errors(self, number: float) -> np.ndarray | None:
        """Return the difference of the first results with this number; None without one."""
        self._function.__globals__.update({_NUMBER: number, _PASS: iter(range(_PASSES))})
        with contextlib.suppress(TypeError, ValueError):
            for result in _quiet(self._results):
                errors = np.ravel(np.array(result, float)) - np.ravel(np.array(self._got[0], float))
                return errors if np.isfinite(errors).all() else None
        return None


def same(got: object, wanted: object) -> bool:
    """Return whether two results are equal but for rounding."""
    if isinstance(wanted, list):
        return isinstance(got, list) and len(got) == len(wanted) and all(map(same, got, wanted))
    if not isinstance(got, (int, float)) or not isinstance(wanted, (int, float)):
        return got == wanted
    # NumPy's single precision is right, too.
    tolerance = TOLERANCE * max(1.0, abs(wanted))
    return got == wanted or abs(got - wanted) < tolerance or (got != got and wanted != wanted)


def _flat(values: Any) -> Iterator[float]:
    """Yield the numbers in lists of lists."""
    for value in values if isinstance(values, list) else ():
        yield from _flat(value)
    if isinstance(values, (int, float)):
        yield values


def _quiet(results: Results) -> Iterator[Any]:
    """Yield results up to the first call that raises an exception."""
    with warnings.catch_warnings(), np.errstate(all="ignore"), contextlib.suppress(Exception):
        warnings.simplefilter("ignore")
        yield from results()


def _slots(node: ast.AST, first: int, end: int) -> list:
    """Return (container, key) of each part in these lines; container[key] is the part."""
    # What is assigned to is no part, but its slice is.
    found: list = []
    queue: list = [node]
    for parent in queue:
        for field, value in ast.iter_fields(parent):
            if field in ("target", "targets"):
                continue
            is_list = isinstance(value, list)
            for key in range(len(value)) if is_list else [field]:
                container = value if is_list else vars(parent)
                part = container[key]
                if isinstance(part, ast.AST):
                    queue.append(part)
                is_part = isinstance(part, (ast.expr, ast.stmt))
                if is_part and first <= part.lineno and part.end_lineno <= end:
                    found.append((container, key))
    assigned = (
        inner for inner in ast.walk(node) if isinstance(getattr(inner, "ctx", 0), ast.Store)
    )
    for inner in assigned:
        is_slice = isinstance(getattr(inner, "slice", None), ast.Slice)
        if is_slice and first <= inner.lineno and inner.end_lineno <= end:
            found.append((vars(inner), "slice"))
    return found


def _changes(node: ast.FunctionDef, slots: list, text: str) -> Iterator[tuple]:
    """Yield ([(container, key, new part)], sentence) of each change of the solution."""
    yield from _like_functions(slots)
    sliced = _sliced(node)
    rows = [(_pattern(pattern), *more) for pattern, *more in _tables()["families"]]
    for row in rows:
        for slot in slots:
            yield from _formed(row, [slot], text, sliced)
    for container, key in slots:
        part = container[key]
        values = getattr(part, "args", getattr(part, "elts", []))
        for first, second in itertools.combinations(range(len(values)), 2):
            swapped = list(values)
            swapped[first], swapped[second] = swapped[second], swapped[first]
            names = {"A": _name(values[first], text), "B": _name(values[second], text)}
            field = "args" if isinstance(part, ast.Call) else "elts"
            yield [(vars(part), field, swapped)], [_tables()["swapped"], names]
        if isinstance(part, ast.AugAssign):
            new = ast.copy_location(ast.Assign([part.target], part.value), part)
            yield [(container, key, new)], [_tables()["kept"], {"A": _name(part.target, text)}]
        if isinstance(part, ast.stmt) and not isinstance(part, ast.Return):
            changed = [*getattr(part, "targets", []), getattr(part, "target", None), part]
            names = {"A": _name(next(filter(None, changed)), text)}
            new = ast.copy_location(ast.Pass(), part)
            yield [(container, key, new)], [_tables()["line"], names]
    yield from _other_sums(slots, text)
    yield from _without_call(slots, text)
    for group in _groups(slots):
        for row in rows:
            yield from _formed(row, group, text, sliced)
    yield from _other_names(node, slots, text)


def _formed(row: tuple, slots: list, text: str, sliced: dict) -> Iterator[tuple]:
    """Yield the change of all these parts by one family, where all have its form."""
    wanted, template, said = row
    places, names = [], {}
    for container, key in slots:
        part = container[key]
        parts: dict = {"S": sliced.get(id(part))} if isinstance(part, ast.Slice) else {}
        if not _is_read(part) or not _matches(wanted, part, parts):
            return
        names = names or {name: _name(part, text) for name, part in parts.items()}
        places.append((container, key, _made(template, parts)))
    if len(places) > 1:
        names["several"] = _tables()["several"].format(len(places))
    yield places, [said, names]


def _groups(slots: list) -> list:
    """Return the groups of parts beside each other, of equal ones, and of those of one form."""
    groups: dict = {}
    for container, key in slots:
        part = container[key]
        if isinstance(part, ast.expr) and key not in ("func", "slice"):
            groups.setdefault(id(container), []).append((container, key))
            form = ast.dump(part)
            if not isinstance(part, (ast.Name, ast.Attribute, ast.Constant)):
                form = re.sub(r"'\w*'|\d[\d.]*", "", form)
            groups.setdefault(form, []).append((container, key))
    return [group for group in groups.values() if len(group) > 1]


def _sliced(node: ast.AST) -> dict:
    """Return what is sliced, by the id of the slice."""
    return {
        id(part): subscript.value
        for subscript in ast.walk(node)
        if isinstance(subscript, ast.Subscript)
        for part in ast.walk(subscript.slice)
    }


def _like_functions(slots: list) -> Iterator[tuple]:
    """Yield the changes of a function to one that students take for it."""
    for container, key in slots:
        part = container[key]
        field = "attr" if isinstance(part, ast.Attribute) else "id"
        name = getattr(part, field, "")
        for alike in _tables()["alike"]:
            for other in alike if name in alike else ():
                names = {"A": f"`{name}`", "B": f"`{other}`"}
                yield [(vars(part), field, other)], [_tables()["other"], names]


def _other_sums(slots: list, text: str) -> Iterator[tuple]:
    """Yield the changes of a sum: to one term, and to a factor that is one of more terms."""
    for container, key in slots:
        terms = _terms(container[key])
        parts: dict = {f"t{i}": part for i, (_, part) in enumerate(terms)}
        for i, (sign, term) in enumerate(terms):
            if len(terms) > 2:
                names = {"A": _name(term, text)}
                yield [(container, key, _made(f"{sign} t{i}", parts))], [_tables()["term"], names]
            operator = {ast.Mult: "*", ast.Div: "/"}.get(type(getattr(term, "op", None)))
            pairs = [(term.left, term.right)] if operator else []
            pairs += [pair[::-1] for pair in pairs if operator == "*"]
            others = [f"{other} t{k}" for k, (other, _) in enumerate(terms) if k != i]
            for inside in itertools.product((True, False), repeat=len(others)):
                wide = " ".join(itertools.compress(others, inside))
                rest = " ".join(term for term, is_in in zip(others, inside) if not is_in)
                template = f"0 {rest} {sign} (a {wide}) {operator} b"
                for first, factor in pairs:
                    made = _made(template, {**parts, "a": first, "b": factor})
                    names = {"A": _name(factor, text), "B": _name(first, text)}
                    yield [(container, key, made)], [_tables()["wide"], names]


def _terms(part: Any) -> list:
    """Return (sign, term) of each term of a sum."""
    if isinstance(part, ast.BinOp) and isinstance(part.op, (ast.Add, ast.Sub)):
        return [*_terms(part.left), ("+" if isinstance(part.op, ast.Add) else "-", part.right)]
    return [("+", part)]


def _without_call(slots: list, text: str) -> Iterator[tuple]:
    """Yield the changes of a call to one of its arguments, or to the difference of two."""
    for container, key in slots:
        part = container[key]
        for count in (1, 2) if isinstance(part, ast.Call) else ():
            for arguments in itertools.permutations(part.args, count):
                made = _made(" - ".join("AB"[:count]), dict(zip("AB", arguments)))
                yield [(container, key, made)], [_tables()["call"], {"A": _name(part, text)}]


def _other_names(node: ast.FunctionDef, slots: list, text: str) -> Iterator[tuple]:
    """Yield the changes of a value to another one of the function, and those by another one."""
    read = [(box, key) for box, key in slots if key != "func" and _is_read(box[key])]
    used = [(box, key) for box, key in read if isinstance(box[key], (ast.Name, ast.Attribute))]
    values = {argument.arg: ast.Name(argument.arg, ast.Load()) for argument in node.args.args}
    values.update((_source(box[key], text), box[key]) for box, key in used)
    sources = [(box, key, _source(box[key], text)) for box, key in used]
    found = dict.fromkeys(source for *_, source in sources)
    for first, second in itertools.combinations(found, 2):
        names = {"A": f"`{first}`", "B": f"`{second}`"}
        other = {first: copy.deepcopy(values[second]), second: copy.deepcopy(values[first])}
        places = [(*place, other[source]) for *place, source in sources if source in other]
        yield places, [_tables()["swapped"], names]
    for first, (name, value) in itertools.product(found, values.items()):
        names = {"A": f"`{first}`", "B": f"`{name}`"}
        places = [(*place, copy.deepcopy(value)) for *place, source in sources if source == first]
        if len(places) > 1:
            yield places, [_tables()["other"], names]
    for template, said in _tables()["by_names"]:
        for container, key in used if template == "B" else read:
            part = container[key]
            for name, value in values.items():
                names = {"A": _name(part, text), "B": f"`{name}`"}
                made = _made(template, {"A": part, "B": value})
                yield [(container, key, made)], [said, names]


def _is_number(part: Any) -> bool:
    """Return whether a part may be a number: it is no comparison."""
    is_truth = isinstance(part, (ast.Compare, ast.BoolOp))
    is_truth |= isinstance(getattr(part, "op", None), ast.Not)
    return isinstance(part, ast.expr) and not is_truth


def _is_read(part: ast.AST) -> bool:
    return isinstance(part, ast.expr) and isinstance(getattr(part, "ctx", ast.Load()), ast.Load)


def _pattern(text: str) -> ast.expr:
    """Return a pattern or a filled template; `S[A:B]` is the slice alone."""
    part: Any = ast.parse(text, mode="eval").body
    is_slice = isinstance(part, ast.Subscript) and isinstance(part.slice, ast.Slice)
    return part.slice if is_slice else part


def _matches(pattern: Any, node: Any, parts: dict) -> bool:
    """Return whether a part has the form of a pattern, whose capital letters stand for any part."""
    if isinstance(pattern, ast.Name) and isinstance(node, ast.expr):
        if len(pattern.id) == 1:
            return ast.dump(parts.setdefault(pattern.id, node)) == ast.dump(node)
        return getattr(node, "attr", getattr(node, "id", "")).replace("arc", "a") == pattern.id
    if isinstance(pattern, list):
        return len(pattern) == len(node) and all(
            _matches(*pair, parts) for pair in zip(pattern, node)
        )
    if not isinstance(pattern, ast.AST):
        return bool(pattern == node)
    fields = [field for field in pattern._fields if field not in ("ctx", "kind")]
    return type(pattern) is type(node) and all(
        _matches(getattr(pattern, field), getattr(node, field), parts) for field in fields
    )


def _made(template: str, parts: dict) -> ast.expr:
    """Return a part in the form of a template; its functions are those of NumPy."""

    class Filled(ast.NodeTransformer):
        def visit_Name(self, name: ast.Name) -> ast.expr:
            if name.id in parts or name.id in (_NUMBER, _GREATEST):
                return copy.deepcopy(parts.get(name.id, name))
            return ast.Attribute(ast.Name(_LIBRARY, ast.Load()), name.id, ast.Load())

    return Filled().visit(_pattern(template))


def _uses_number(part: Any) -> bool:
    is_node = isinstance(part, ast.AST)
    return is_node and any(getattr(node, "id", "") == _NUMBER for node in ast.walk(part))


def _name(part: ast.AST, text: str) -> str:
    """Return a part as text; of a long one, the name in it that is rarest in the file."""
    shown = _source(part, text)
    if isinstance(part, ast.Call) and isinstance(part.func, (ast.Name, ast.Attribute)):
        return f"`{_source(part.func, text)}(...)`"
    if len(shown) <= _SHORT and isinstance(part, (ast.Name, ast.Attribute, ast.Constant)):
        return f"`{shown}`"
    names = [node for node in ast.walk(part) if isinstance(node, (ast.Name, ast.Attribute))]
    texts = [_source(node, text) for node in names]
    texts = [name for name in texts if not name.endswith((".inf", ".nan"))] or texts
    if not texts:
        return f"`{shown[:_SHORT]}`"
    return f"the part with `{min(texts, key=text.count)}`"


@lru_cache(maxsize=1)
def _lines(text: str) -> list:
    return text.split("\n")


def _source(part: Any, text: str) -> str:
    """Return the text of a part, of a long one the text of its first line."""
    first = _lines(text)[part.lineno - 1]
    return first[part.col_offset : part.end_col_offset if part.lineno == part.end_lineno else None]


def _meaning(number: float, part: str = "") -> str | None:
    """Return the sentence about a factor of a part of the solution, where it has one."""
    for value, text, *of in _tables()["numbers"]:
        if math.isclose(number, value, abs_tol=1e-6) and re.search("".join(of), part):
            return text
    return None


def _filled(said: list, number: float | None) -> str:
    """Return the sentence of a change."""
    text, names = said
    if number is not None and not text:
        text = _tables()["number"]
    found = text + names.get("several", "")
    found = found.format(**names, c="" if number is None else f"{number:.4g}")
    return found[:1].upper() + found[1:]
