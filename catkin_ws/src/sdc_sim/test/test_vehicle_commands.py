"""Commands beyond their limits."""

from __future__ import annotations

import dataclasses

import pytest

from sdc_common.driving import Command


@pytest.mark.parametrize(
    ("key", "value", "limit"),
    [
        ("throttle", 1.5, 1.0),
        ("throttle", -0.5, 0.0),
        ("steer", 1.5, 1.0),
        ("steer", -1.5, -1.0),
        ("brake", 1.5, 1.0),
        ("brake", -0.5, 0.0),
    ],
)
def test_value_out_of_its_range_is_limited_and_reported(key, value, limit):
    command = Command(0.2, 0.1, 0.3, hand_brake=True, reverse=True)
    limited, was_limited = dataclasses.replace(command, **{key: value}).clamped()
    assert was_limited
    assert limited == dataclasses.replace(command, **{key: limit})
