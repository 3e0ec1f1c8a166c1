import math

import pytest
from geometry_msgs.msg import Quaternion
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry

from sdc_common.ros.conversion import pose_and_speed, rear_axle_speed, yaw_from_quaternion


def odometry(x=0.0, y=0.0, orientation=(0.0, 0.0, 0.0, 1.0), velocity=(0.0, 0.0)):
    message = Odometry()
    message.pose.pose.position.x, message.pose.pose.position.y = x, y
    message.pose.pose.orientation = Quaternion(*orientation)
    message.twist.twist.linear.x, message.twist.twist.linear.y = velocity
    return message


@given(st.floats(-3.14, 3.14), st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
def test_yaw_is_that_of_yaw_pitch_and_roll(yaw, pitch, roll):
    cy, sy, cp, sp, cr, sr = (f(a / 2) for a in (yaw, pitch, roll) for f in (math.cos, math.sin))
    q = Quaternion(
        x=sr * cp * cy - cr * sp * sy,
        y=cr * sp * cy + sr * cp * sy,
        z=cr * cp * sy - sr * sp * cy,
        w=cr * cp * cy + sr * sp * sy,
    )
    assert yaw_from_quaternion(q) == pytest.approx(yaw, abs=1e-9)


def test_pose_and_speed_are_those_of_the_message():
    orientation = 0.0, 0.0, math.sin(0.5), math.cos(0.5)
    x, y, yaw, speed = pose_and_speed(odometry(1.0, 2.0, orientation, (-3.0, 4.0)))
    assert (x, y, speed) == (1.0, 2.0, 5.0)
    assert yaw == pytest.approx(1.0)


@pytest.mark.parametrize("axis", range(4))
@pytest.mark.parametrize("norm_squared", [0.95, 1.0, 1.05])
def test_quaternion_of_about_unit_norm_is_accepted(axis, norm_squared):
    orientation = [0.0] * 4
    orientation[axis] = -math.sqrt(norm_squared)
    pose_and_speed(odometry(orientation=orientation))


@pytest.mark.parametrize(
    "orientation",
    [
        (0.0, 0.0, 0.0, 0.0),
        (math.nan, 0.0, 0.0, 1.0),
        (0.65, 0.0, 0.65, 0.0),
        (0.0, 0.75, 0.0, 0.8),
        (1.0, 1.0, 0.0, 0.0),
    ],
)
def test_quaternion_of_another_norm_is_refused(orientation):
    with pytest.raises(ValueError, match="^its orientation is not a unit quaternion$"):
        pose_and_speed(odometry(orientation=orientation))


@pytest.mark.parametrize("wrong", [{"x": math.nan}, {"y": math.inf}, {"velocity": (math.nan, 0.0)}])
def test_number_that_is_not_finite_is_refused(wrong):
    with pytest.raises(ValueError, match="^one of its numbers is not finite$"):
        pose_and_speed(odometry(**wrong))


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
