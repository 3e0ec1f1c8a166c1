import math

import pytest

from sdc_common.validation import (
    check_between,
    check_finite,
    check_non_negative,
    check_positive,
    is_number,
)

NO_NUMBERS = [math.nan, math.inf, -math.inf, True, False, None, "1.0", [1.0], 10**400]


@pytest.mark.parametrize("value", [0, -1, 2.5, 1e-300, 10**300])
def test_finite_ints_and_floats_are_numbers(value):
    assert is_number(value)
    check_finite(gain=value)


@pytest.mark.parametrize("value", NO_NUMBERS)
def test_what_is_no_finite_number_is_refused_by_each_check(value):
    assert not is_number(value)
    for check, limits in (
        (check_positive, ()),
        (check_non_negative, ()),
        (check_finite, ()),
        (check_between, (-math.inf, math.inf)),
    ):
        with pytest.raises(ValueError, match="^gain must be a .*number"):
            check(*limits, gain=value)


@pytest.mark.parametrize(
    ("check", "limits", "accepted", "refused", "text"),
    [
        (check_positive, (), (1e-9, 5), (0, -1e-9), "a positive number"),
        (check_non_negative, (), (0, 0.0, 5), (-1e-9,), "a number that is not negative"),
        (check_finite, (), (-5, 0, 5.0), (math.nan,), "a finite number"),
        (check_between, (-1.0, 2.5), (-1, 0.0, 2.5), (-1.1, 2.6), "a number from -1 to 2.5"),
    ],
)
def test_first_value_beyond_the_limits_is_named(check, limits, accepted, refused, text):
    for good in accepted:
        check(*limits, first=good, second=good)
        for bad in refused:
            with pytest.raises(ValueError) as error:
                check(*limits, first=good, second=bad, third=bad)
            assert str(error.value) == f"second must be {text}, got {bad!r}"
