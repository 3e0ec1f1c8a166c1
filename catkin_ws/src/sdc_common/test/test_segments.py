"""The numbers of a line's segments, in plain functions and in machine code."""

import sys

import numpy as np
import pytest

from sdc_common.geometry import segments
from sdc_common.geometry.polyline import Polyline
from sdc_common.machine_code import numba_module

REPEATED = [(1.0, 2.0), (4.0, 6.0), (4.0, 6.0), (4.0, 5.5)]


@pytest.fixture(autouse=True)
def plain_functions(monkeypatch):
    """A drive in machine code may have come before, in the same process."""
    monkeypatch.setattr(segments, "_in_machine_code", False)


def test_lines_are_arrays_only_with_numba():
    assert not Polyline(REPEATED).numbers.are_arrays
    segments.use_machine_code()
    assert Polyline(REPEATED).numbers.are_arrays == (numba_module() is not None)


@pytest.mark.parametrize("as_array", [False, True])
def test_line_of_arrays_equals_a_plain_one_bit_for_bit(as_array, monkeypatch):
    """The functions of arrays are compiled if Numba is installed."""
    random = np.random.default_rng(5)
    walks = []
    for count, extend in ((2, True), (3, False), (40, True), (40, False), (300, False)):
        steps = random.normal(size=(count, 2))  # the line turns around itself
        steps[5:7] = 0.0  # two points repeat the one before them
        points = [tuple(row) for row in np.cumsum(steps, axis=0).tolist()]
        walks.append((points, extend, Polyline(points, extend)))
    monkeypatch.setattr(segments, "_in_machine_code", True)
    for points, extend, plain in walks:
        arrays = Polyline(np.array(points) if as_array else points, extend)
        assert arrays.numbers.are_arrays
        assert isinstance(arrays.numbers.points, np.ndarray)
        assert not plain.numbers.are_arrays
        for name in ("lengths", "s", "headings"):
            assert getattr(arrays, name) == getattr(plain, name)
        plain.set_headings([0.9 * heading for heading in plain.headings])
        arrays.set_headings(plain.headings)
        assert arrays.numbers.headings.tolist() == plain.numbers.headings == plain.headings
        for _ in range(50):
            point = random.normal(scale=5.0, size=2).tolist()
            first = int(random.integers(len(plain.lengths)))
            for window in ((), (first, first + 5)):
                # repr shows the sign of a zero, and NaN equals itself.
                assert repr(arrays.nearest(*point, *window)) == repr(plain.nearest(*point, *window))
        assert repr(arrays.nearest(np.nan, 0.0)) == repr(plain.nearest(np.nan, 0.0))


def test_numba_that_cannot_be_imported_is_named_once(monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)
    numba_module.cache_clear()
    with pytest.warns(RuntimeWarning, match="40 times slower without Numba .*numpy<1.25") as caught:
        assert numba_module() is numba_module() is None
    assert len(caught) == 1
    numba_module.cache_clear()
