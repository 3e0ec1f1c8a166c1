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


def test_curve_has_no_value_at_nan():
    with pytest.raises(ValueError, match="^a piecewise linear curve has no value at nan$"):
        evaluate(math.nan, linear_segments(POINTS, VALUES))
