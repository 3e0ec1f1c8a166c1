"""The interface of steering methods, and the prediction that several of them use."""

import math

import pytest

from sdc_package.steering.method import predicted_pose


@pytest.mark.parametrize("yaw", [0.0, 0.5, -2.0])
@pytest.mark.parametrize("rate", [0.0, 1.0, -0.8])
def test_prediction_follows_the_arc_of_the_car(yaw, rate):
    """Many small steps along the heading give the arc."""
    x, y, heading = 1.0, 2.0, yaw
    for _ in range(1000):
        heading += 0.5 * rate * 0.3 / 1000
        x, y = x + 0.003 * math.cos(heading), y + 0.003 * math.sin(heading)
        heading += 0.5 * rate * 0.3 / 1000
    predicted = predicted_pose(1.0, 2.0, yaw, 10.0, rate, 0.3)
    assert predicted == pytest.approx((x, y, yaw + 0.3 * rate), abs=0.02)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_jump_of_the_pose_is_not_a_yaw_rate(side):
    wanted = predicted_pose(1.0, 2.0, 0.5, 10.0, side * 1.5, 0.1)
    assert predicted_pose(1.0, 2.0, 0.5, 10.0, side * 60.0, 0.1) == wanted
    assert wanted[2] == pytest.approx(0.5 + side * 0.15)
