"""Messages of pictures, and what daylight and the spectator's pose mean for them."""

import io
import math

import cv2
import numpy as np
import pytest
import rospy
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo

from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.ros.picture_messages import (
    camera_info_message,
    camera_mount,
    compressed_message,
    daylight,
    spectator_mount,
)


def test_camera_info_describes_the_pinhole_with_a_field_of_view_of_90_degrees():
    buffer = io.BytesIO()
    camera_info_message(CameraModel(), "front").serialize(buffer)
    info = CameraInfo().deserialize(buffer.getvalue())
    assert (info.width, info.height, info.header.frame_id) == (640, 480, "front")
    assert (info.distortion_model, list(info.D)) == ("plumb_bob", [0.0] * 5)
    k, r, p = (np.reshape(one, (3, -1)) for one in (info.K, info.R, info.P))
    np.testing.assert_allclose(k, [[320.0, 0.0, 320.0], [0.0, 320.0, 240.0], [0.0, 0.0, 1.0]])
    np.testing.assert_array_equal(r, np.eye(3))
    np.testing.assert_array_equal(p, np.column_stack([k, np.zeros(3)]))


def test_compressed_picture_is_a_jpeg_of_the_same_colours():
    picture = np.full((48, 64, 4), (200, 120, 40, 255), np.uint8)
    message = compressed_message(picture, rospy.Time(3, 5), "front")
    assert (message.header.stamp, message.header.frame_id) == (rospy.Time(3, 5), "front")
    assert message.format == "bgr8; jpeg compressed bgr8"
    decoded = cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_COLOR)
    np.testing.assert_allclose(decoded, picture[:, :, :3], atol=4)


def test_daylight_is_the_height_of_the_sun():
    assert [daylight(angle) for angle in (-90.0, -5.0, 90.0, 900.0)] == [0.0, 0.0, 1.0, 1.0]
    assert daylight(30.0) == pytest.approx(0.5)
    with pytest.raises(ValueError, match="nan"):
        daylight(math.nan)


def spectator_pose(yaw, pitch_down, frame="hero", z=3.0):
    """Return the pose of a camera with x right, y up, z backward that looks along yaw."""
    c, s = math.cos(yaw), math.sin(yaw)
    level, down = math.cos(pitch_down), math.sin(pitch_down)
    right, backward = np.array([s, -c, 0.0]), np.array([-c * level, -s * level, down])
    rotation = np.column_stack([right, np.cross(backward, right), backward])
    pose = PoseStamped()
    pose.header.frame_id = frame
    pose.pose.position.x, pose.pose.position.z = -6.0, z
    pose.pose.orientation = Quaternion(*Rotation.from_matrix(rotation).as_quat())
    return pose


@pytest.mark.parametrize(("yaw", "pitch"), [(0.0, 0.0), (0.4, 0.2), (-1.0, 0.3)])
def test_spectator_looks_where_its_pose_points(yaw, pitch):
    x, y, z, mount_yaw, mount_pitch = spectator_mount(spectator_pose(yaw, pitch), "hero")
    assert (x, y, z) == (-6.0, 0.0, 3.0)
    assert (mount_yaw, mount_pitch) == (pytest.approx(yaw), pytest.approx(pitch))
    # RViz's panel turns the axes of the camera to those of a body, which the bridge expects.
    turn = Quaternion(*Rotation.from_euler("ZY", (yaw, pitch)).as_quat())
    pose = Pose(Point(-6.0, 0.0, 3.0), turn)
    assert camera_mount(pose) == pytest.approx((x, y, z, yaw, pitch))


@pytest.mark.parametrize(
    ("pose", "reason"),
    [
        (spectator_pose(0.0, 0.0, frame="map"), "frame is 'map'; use hero"),
        (spectator_pose(0.0, 1.2), "of the horizon"),
        (spectator_pose(0.0, 0.0, z=-1.0), "above"),
        (spectator_pose(0.0, 0.0, z=math.nan), "above"),
        (PoseStamped(), "frame"),
    ],
)
def test_spectator_pose_that_cannot_be_drawn_is_refused(pose, reason):
    with pytest.raises(ValueError, match=reason):
        spectator_mount(pose, "hero")
