import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry

from sdc_package.odometry import pose_and_speed, yaw_from_quaternion


def odometry(yaw=0.0, **twist):
    message = Odometry()
    message.pose.pose.orientation.z = math.sin(yaw / 2)
    message.pose.pose.orientation.w = math.cos(yaw / 2)
    for axis, value in twist.items():
        setattr(message.twist.twist.linear, axis, value)
    return message


@given(st.floats(-3.14, 3.14), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_yaw_is_correct_for_any_attitude(yaw, pitch, roll):
    cy, sy, cp, sp, cr, sr = (f(a / 2) for a in (yaw, pitch, roll) for f in (math.cos, math.sin))
    q = Odometry().pose.pose.orientation
    q.w, q.x = cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy
    q.y, q.z = cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy
    assert yaw_from_quaternion(q) == pytest.approx(yaw, abs=1e-9)


def test_speed_is_the_magnitude_of_the_twist():
    assert pose_and_speed(odometry(yaw=1.0, x=-3.0, y=4.0))[2:] == (pytest.approx(1.0), 5.0)


@pytest.mark.parametrize(
    "break_it",
    [
        lambda m: setattr(m.pose.pose.position, "x", math.nan),
        lambda m: setattr(m.twist.twist.linear, "y", math.inf),
        lambda m: setattr(m.pose.pose.orientation, "w", math.nan),
        lambda m: setattr(m.pose.pose.orientation, "w", 0.0),
    ],
)
def test_message_with_a_number_that_is_not_finite_is_refused(break_it):
    message = odometry()
    break_it(message)
    with pytest.raises(ValueError):
        pose_and_speed(message)
