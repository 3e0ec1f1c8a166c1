import math

import numpy as np
import rospy
from nav_msgs.msg import Odometry
from sdc_package.msg import BaseWaypoint, CarlaVehicleControl, LocalPath, Path, Waypoint

from sdc_package.odometry import pose_and_speed
from sdc_sim.camera import CameraModel
from sdc_sim.messages import camera_info_message, image_message, odometry_message, vehicle_transform
from sdc_sim.vehicle import VehicleState


def test_control_has_the_md5_sum_of_the_bridge():
    assert CarlaVehicleControl._md5sum == "50204ce132bb8c412ae626da2714a5ea"


def test_fields_of_the_contract():
    assert (BaseWaypoint.__slots__, BaseWaypoint._slot_types) == (["x", "y"], ["float32", "float32"])
    assert (Waypoint.__slots__, Waypoint._slot_types) == (["x", "y", "v"], ["float32"] * 3)
    assert (Path.__slots__, LocalPath.__slots__) == (["waypoints"], ["waypoints"])


def test_odometry_there_and_back():
    state = VehicleState(x_m=1.0, y_m=-2.0, yaw_rad=2.5, speed_mps=3.0, lateral_speed_mps=4.0, yaw_rate_radps=0.5)
    message = odometry_message(state, rospy.Time(7))
    x, y, yaw, speed = pose_and_speed(message)
    assert (x, y, speed) == (1.0, -2.0, 5.0)
    assert math.isclose(yaw, 2.5)
    assert message.twist.twist.angular.z == 0.5
    transform = vehicle_transform(message)
    assert (transform.header.frame_id, transform.child_frame_id) == ("map", "ego_vehicle")
    assert transform.transform.rotation == message.pose.pose.orientation
    assert isinstance(message, Odometry)


def test_image_keeps_every_pixel():
    picture = np.random.default_rng(0).integers(0, 255, (480, 640, 4), dtype=np.uint8)
    message = image_message(picture, rospy.Time(7))
    assert (message.step, len(message.data)) == (2560, 480 * 2560)
    np.testing.assert_array_equal(np.frombuffer(message.data, np.uint8).reshape(picture.shape), picture)


def test_camera_info_has_90_degrees():
    info = camera_info_message(CameraModel())
    assert 2.0 * math.degrees(math.atan(info.width / 2.0 / info.K[0])) == 90.0
    assert (info.K[2], info.K[5]) == (320.0, 240.0)
    assert info.P[:3] == info.K[:3]
