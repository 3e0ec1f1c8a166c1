import math

import pytest

from sdc_common.piecewise_linear import evaluate, linear_segments

POINTS, VALUES = (1.0, 3.0, 4.0), (10.0, 20.0, 5.0)


@pytest.mark.parametrize(
    ("x", "value"),
    [(1.0, 10.0), (1.5, 12.5), (2.0, 15.0), (3.0, 20.0), (3.5, 12.5), (3.9, 6.5), (4.0, 5.0)],
)
def test_curve_is_linear_between_its_points(x, value):
    assert evaluate(x, linear_segments(POINTS, VALUES)) == pytest.approx(value)


@pytest.mark.parametrize(
    ("x", "value"), [(-math.inf, 10.0), (-5.0, 10.0), (4.5, 5.0), (100.0, 5.0), (math.inf, 5.0)]
)
def test_curve_is_constant_beyond_its_ends(x, value):
    assert evaluate(x, linear_segments(POINTS, VALUES)) == value


def test_curve_has_exactly_its_values_at_its_points():
    points, values = [0.1, 0.7, 1.1], [1.0 / 3.0, 2.0 / 3.0, 0.2]
    curve = linear_segments(points, values)
    assert [evaluate(x, curve) for x in points] == values


def test_curve_of_one_point_is_constant():
    curve = linear_segments([2.0], [7.0])
    assert [evaluate(x, curve) for x in (-1.0, 2.0, 3.0)] == [7.0] * 3


def test_segments_are_ordered_from_the_last_to_the_first():
    assert linear_segments(POINTS, VALUES) == (
        (4.0, 5.0, 0.0),
        (3.0, 20.0, -15.0),
        (1.0, 10.0, 5.0),
        (-math.inf, 10.0, 0.0),
    )


def test_curve_has_no_value_at_nan():
    with pytest.raises(ValueError, match="^a piecewise linear curve has no value at nan$"):
        evaluate(math.nan, linear_segments(POINTS, VALUES))
