import math
import operator

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry

from sdc_common.ros import odometry as of_the_world
from sdc_package import odometry as of_the_car

# The student's functions, and those of the world.
both = pytest.mark.parametrize("module", [of_the_car, of_the_world], ids=["car", "world"])


def odometry(yaw=0.0, **twist):
    message = Odometry()
    message.pose.pose.orientation.z = math.sin(yaw / 2)
    message.pose.pose.orientation.w = math.cos(yaw / 2)
    for axis, value in twist.items():
        setattr(message.twist.twist.linear, axis, value)
    return message


@both
@given(st.floats(-3.14, 3.14), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_yaw_is_correct_for_any_attitude(module, yaw, pitch, roll):
    cy, sy, cp, sp, cr, sr = (f(a / 2) for a in (yaw, pitch, roll) for f in (math.cos, math.sin))
    q = Odometry().pose.pose.orientation
    q.w, q.x = cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy
    q.y, q.z = cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy
    assert module.yaw_from_quaternion(q) == pytest.approx(yaw, abs=1e-9)


@both
def test_speed_is_the_magnitude_of_the_twist(module):
    assert module.pose_and_speed(odometry(yaw=1.0, x=-3.0, y=4.0))[2:] == (pytest.approx(1.0), 5.0)


@both
@pytest.mark.parametrize(("axis", "yaw"), [("x", 0.0), ("y", math.pi), ("z", math.pi), ("w", 0.0)])
def test_orientation_may_be_any_unit_quaternion(module, axis, yaw):
    message = odometry()
    for name in "xyzw":
        setattr(message.pose.pose.orientation, name, 1.0 if name == axis else 0.0)
    assert module.pose_and_speed(message)[2] == yaw


@both
@pytest.mark.parametrize("length", [0.0, 0.94, 1.06, 1.4, math.nan])
def test_orientation_that_is_not_a_unit_quaternion_is_refused(module, length):
    message = odometry()
    message.pose.pose.orientation.w = length
    with pytest.raises(ValueError, match="^its orientation is not a unit quaternion$"):
        module.pose_and_speed(message)


@both
@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("part", ["pose.pose.position", "twist.twist.linear"])
@pytest.mark.parametrize("axis", "xy")
def test_message_with_a_number_that_is_not_finite_is_refused(module, part, axis, number):
    message = odometry()
    setattr(operator.attrgetter(part)(message), axis, number)
    with pytest.raises(ValueError, match="^one of its numbers is not finite$"):
        module.pose_and_speed(message)
