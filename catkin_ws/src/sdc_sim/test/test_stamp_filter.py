import math

import pytest

from sdc_sim.evaluation.stamp_filter import StampFilter


@pytest.mark.parametrize(
    ("stamps", "accepted"),
    [
        ([0.05, 0.05, 0.1, 4.0], [0.05, 0.1, 4.0]),
        ([5.0, 15.0, 25.5], [5.0, 15.0]),
        ([10.0, 9.9, 10.05, 9.95, 10.1], [10.0, 10.05, 10.1]),
        ([30.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 30.1], [30.0, 30.1]),
        ([30.0, 100.0, 110.0, 120.0, 130.0, 140.0, 140.1], [30.0, 140.0, 140.1]),
        ([30.0, *[100.0] * 8], [30.0]),
        ([30.0, *(1000.0 - 20.0 * n for n in range(20))], [30.0]),
        *(([5.0, bad, 5.05, 5.1], [5.0, 5.05, 5.1]) for bad in (0.02, -1.0, 1e9, math.nan)),
    ],
    ids=["repeated", "step", "second publisher", "back", "gap", "same", "no agreement", *"abcd"],
)
def test_stamps_advance_and_one_bad_stamp_is_ignored(stamps, accepted):
    found = StampFilter()
    assert [stamp for stamp in stamps if found.accepts(stamp)] == accepted
