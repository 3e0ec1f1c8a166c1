import math

import numpy as np
import pytest
from nav_msgs.msg import Odometry

from sdc_common.ros.odometry import pose_and_speed
from sdc_localization.localizer import Estimate
from sdc_localization.odometry_message import fill_odometry, transform, wheel_speed

NAMES = ["front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel"]
COVARIANCE = np.array([[4.0, 1.0, 0.5], [1.0, 5.0, 0.6], [0.5, 0.6, 6.0]])


def test_speed_is_that_of_the_rear_wheels():
    assert wheel_speed(NAMES, [9.0, 9.0, 20.0, 30.0], 0.4) == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("names", "speeds", "message"),
    [(NAMES[:3], [1.0] * 3, "no wheel 'rear_right_wheel'"), (NAMES, [math.nan] * 4, "not finite")],
)
def test_bad_wheel_speeds_are_refused(names, speeds, message):
    with pytest.raises(ValueError, match=message):
        wheel_speed(names, speeds, 0.35)


def test_message_has_pose_speed_and_covariance_of_the_estimate():
    estimate = Estimate(1.0, 2.0, -2.5, 3.0, 4.0, 0.5, COVARIANCE)
    message = fill_odometry(Odometry(), estimate)
    assert pose_and_speed(message) == pytest.approx((1.0, 2.0, -2.5, 5.0))
    assert message.twist.twist.angular.z == 0.5
    rows = np.reshape(message.pose.covariance, (6, 6))
    assert (rows[np.ix_((0, 1, 5), (0, 1, 5))] == COVARIANCE).all()
    assert not rows[2:5].any()
    assert transform(message).transform.translation.y == 2.0
