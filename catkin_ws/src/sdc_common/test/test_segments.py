"""The numbers of a line's segments, in plain functions and in machine code."""

import math

import numpy as np
import pytest

from sdc_common.geometry import segments
from sdc_common.geometry.polyline import Polyline
from sdc_common.machine_code import numba_module

REPEATED = [(1.0, 2.0), (4.0, 6.0), (4.0, 6.0), (4.0, 5.5)]
UP_RIGHT_RAD, DOWN_RAD = math.atan2(4.0, 3.0), -0.5 * math.pi


@pytest.fixture(autouse=True)
def plain_functions(monkeypatch):
    """A drive in machine code may have come before, in the same process."""
    monkeypatch.setattr(segments, "_in_machine_code", False)


@pytest.mark.parametrize(
    ("extend", "beyond_m"), [(False, (0.0, 0.5)), (True, (-math.inf, math.inf))]
)
def test_numbers_of_a_line(extend, beyond_m):
    numbers = segments.line_numbers(REPEATED, extend)
    assert numbers.points == REPEATED
    assert numbers.lengths == [5.0, 0.0, 0.5]
    assert len(numbers.segments) == 3
    assert numbers.segments[0] == (1.0, 2.0, 0.6, 0.8, beyond_m[0], 5.0)
    np.testing.assert_equal(numbers.segments[1], (math.nan, math.nan, 0.0, 0.0, 0.0, 0.0))
    assert numbers.segments[2] == (4.0, 6.0, 0.0, -1.0, 0.0, beyond_m[1])
    mean_rad = 0.5 * (UP_RIGHT_RAD + DOWN_RAD)
    assert numbers.headings == [UP_RIGHT_RAD, UP_RIGHT_RAD, mean_rad, DOWN_RAD]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_headings_continue_past_half_a_turn_at_the_second_segment(side):
    points = [(0.0, 0.0), (-10.0, side), (-20.0, 0.0), (-10.0, -side)]
    slope = side * math.atan(0.1)
    directions = [side * math.pi - slope, side * math.pi + slope, side * 2.0 * math.pi - slope]
    means = [0.5 * (one + other) for one, other in zip(directions, directions[1:])]
    headings = segments.line_numbers(points, False).headings
    assert headings == pytest.approx([directions[0], *means, directions[-1]])


def test_headings_continue_over_several_turns():
    points = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] * 3
    headings = segments.line_numbers(points, False).headings
    quarters = [0.0, *np.arange(0.5, 10.0), 10.0]
    assert headings == pytest.approx([0.5 * math.pi * quarter for quarter in quarters])


@pytest.mark.parametrize(
    ("point", "first", "last", "expected"),
    [
        ((9.0, 0.0), 0, 3, (0, 4.0, 3.0)),
        ((9.0, 0.0), 1, 3, (1, 3.0, 6.0)),
        ((14.0, -5.0), 0, 3, (0, 9.0, -2.0)),
        ((2.0, 1.0), 0, 3, (0, 0.0, 5.0)),
        ((2.0, -7.0), 0, 3, (0, 0.0, -5.0)),
        ((9.0, 5.5), 0, 3, (2, 6.0, 1.5)),
        ((-4.0, 10.0), 0, 3, (2, 15.0, -5.0)),
        # As near to two segments: the first.
        ((13.0, -1.0), 0, 3, (0, 8.0, 2.0)),
    ],
)
def test_nearest_segment_of_two_corners_to_the_left(point, first, last, expected):
    line = segments.line_numbers([(5.0, -3.0), (15.0, -3.0), (15.0, 7.0), (0.0, 7.0)], False)
    assert segments.nearest_segment(line.segments, *point, first, last) == expected


def test_point_that_is_not_finite_is_at_no_position_of_the_first_segment_searched():
    line = segments.line_numbers([(float(x), 0.0) for x in range(5)], True)
    segment, along_m, distance_m = segments.nearest_segment(line.segments, math.nan, 0.0, 2, 4)
    assert (segment, distance_m) == (2, math.inf)
    assert math.isnan(along_m)


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
        plain.headings = arrays.headings = [0.9 * heading for heading in plain.headings]
        assert arrays.numbers.headings.tolist() == plain.numbers.headings == plain.headings
        for _ in range(50):
            point = random.normal(scale=5.0, size=2).tolist()
            first = int(random.integers(len(plain.lengths)))
            for window in ((), (first, first + 5)):
                # repr shows the sign of a zero, and NaN equals itself.
                assert repr(arrays.nearest(*point, *window)) == repr(plain.nearest(*point, *window))
        assert repr(arrays.nearest(np.nan, 0.0)) == repr(plain.nearest(np.nan, 0.0))


@pytest.mark.parametrize("are_arrays", [False, True])
def test_new_rows_can_be_filled(are_arrays):
    rows = segments.new_rows(3, are_arrays)
    for row in range(3):
        rows[row] = (row, 0.5)
    assert len(rows) == 3
    assert isinstance(rows, np.ndarray) == are_arrays
    assert [tuple(row) for row in rows] == [(0.0, 0.5), (1.0, 0.5), (2.0, 0.5)]
