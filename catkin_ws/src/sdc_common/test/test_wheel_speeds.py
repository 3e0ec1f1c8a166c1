import math

import pytest

from sdc_common.ros.conversion import rear_axle_speed


def test_speed_is_the_mean_of_the_rear_wheels():
    names = ["front_left_wheel", "rear_left_wheel", "rear_right_wheel"]
    assert rear_axle_speed(names, [99.0, 10.0, 12.0], 0.35) == pytest.approx(3.85)


@pytest.mark.parametrize("rates", [[1.0, math.nan], [1.0, math.inf]])
def test_bad_wheel_speed_is_refused(rates):
    with pytest.raises(ValueError, match="not finite"):
        rear_axle_speed(["rear_left_wheel", "rear_right_wheel"], rates, 0.35)


def test_missing_wheel_is_refused():
    with pytest.raises(ValueError, match="rear_right_wheel"):
        rear_axle_speed(["rear_left_wheel"], [1.0], 0.35)
