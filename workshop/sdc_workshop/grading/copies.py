"""Which submissions are equal but for names and layout.

Lines of the templates do not count. What the solution has, too, counts apart: the guide shows it,
so that two students who follow the guide are equal without a copy.
"""

from __future__ import annotations

import itertools
import keyword
import re
from pathlib import Path
from typing import Iterator, NamedTuple

import numpy as np

from sdc_workshop.steps import WORKSHOP
from sdc_workshop.student_file import read_anyway
from sdc_workshop.workspace import (
    files_to_make,
    package_files,
    package_of,
    solution,
    solution_text,
    template_of,
)

# As many tokens in a row must be equal.
_RUN = 6
_MAX_TOKENS = 20_000
_ENDINGS = (".py", ".launch", ".xml", ".txt", ".sh", ".msg")
_TOKEN = re.compile(r"""[^\W\d]\w*|\d[\w.]*|"[^"\n]*"|'[^'\n]*'|\S""")
_COMMENT = re.compile(r"(?m)#.*$|<!--|-->")


class Copy(NamedTuple):
    """Two students, the share of their tokens that are equal, and those not in the solution."""

    first: str
    second: str
    equal_percent: float
    own_equal_tokens: int


def written_tokens(src: Path, lab: str = WORKSHOP) -> list:
    """Return the tokens that a student has written in a src folder; all names are one token."""
    known = set(package_files(lab))
    names = [str(path.relative_to(src)) for path in (src / package_of(lab)).rglob("*")]
    # First the files that every student has: others must not push them out.
    names.sort(key=lambda name: (name not in known, name))
    words = (word for name in names for word in _words(src, name, lab))
    return list(itertools.islice(words, _MAX_TOKENS))


def _words(src: Path, name: str, lab: str) -> Iterator[str]:
    path, given = src / name, ""
    if path.suffix not in _ENDINGS or not path.is_file():
        return
    if name not in files_to_make(lab) and solution(name).is_file():
        given = template_of(name) or solution_text(name)
    known = {line.strip() for line in given.split("\n")}
    lines = (line for line in read_anyway(path).split("\n") if line.strip() not in known)
    for match in _TOKEN.finditer(_COMMENT.sub("", "\n".join(lines))):
        is_name = match[0].isidentifier() and not keyword.iskeyword(match[0])
        yield "name" if is_name else match[0]


def copies(tokens: dict, lab: str = WORKSHOP) -> list:
    """Return each pair of students, most suspicious first, from their tokens by their names."""
    known = _runs(written_tokens(solution(package_of(lab)).parent, lab))
    runs = {name: _runs(words) for name, words in tokens.items() if len(words) >= _RUN}
    own = {name: ~_covered(found, known) for name, found in runs.items()}
    pairs = []
    for first, second in itertools.combinations(runs, 2):
        equal = [_covered(runs[a], runs[b]) for a, b in ((first, second), (second, first))]
        total = sum(map(len, equal))
        both = [int((one & own[name]).sum()) for one, name in zip(equal, (first, second))]
        percent = 100.0 * sum(int(one.sum()) for one in equal) / total
        pairs.append(Copy(first, second, round(percent, 1), min(both)))
    return sorted(pairs, key=lambda pair: (-pair.own_equal_tokens, -pair.equal_percent, pair))


def _runs(words: list) -> np.ndarray:
    """Return a number for each run of tokens, the same for equal runs."""
    return np.array([hash(tuple(words[at : at + _RUN])) for at in range(len(words) - _RUN + 1)])


def _covered(runs: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return of each token whether it is in a run that the others have, too."""
    found = np.zeros(len(runs) + _RUN - 1, dtype=bool)
    same = np.isin(runs, others)
    for shift in range(_RUN):
        found[shift : shift + len(runs)] |= same
    return found
