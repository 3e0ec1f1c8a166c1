"""Commands beyond their limits."""

from __future__ import annotations

import dataclasses

import pytest

from sdc_common.driving import Command


@pytest.mark.parametrize("key", ["throttle", "steer", "brake"])
def test_value_out_of_its_range_is_limited_and_reported(key):
    command, least = Command(0.2, 0.1, 0.3, True, True), -1.0 if key == "steer" else 0.0
    for value, limit in ((1.5, 1.0), (least - 0.5, least)):
        limited = dataclasses.replace(command, **{key: value}).clamped()
        assert limited == (dataclasses.replace(command, **{key: limit}), True)
