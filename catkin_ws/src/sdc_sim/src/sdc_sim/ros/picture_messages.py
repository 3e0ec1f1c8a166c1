"""Conversion between pictures, their camera and ROS messages."""

from __future__ import annotations

import math
from typing import IO, NamedTuple, Sequence

import cv2
import numpy as np
import rospy
from geometry_msgs.msg import Pose, PoseStamped
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

from sdc_common.ros.odometry import unit
from sdc_sim.camera.camera_model import CameraModel

# Limits of the spectator's camera: the renderer draws a view near the horizon.
_MAX_SPECTATOR_M = 50.0
_MAX_SPECTATOR_PITCH_RAD = 0.49
_LEAST_SPECTATOR_HEIGHT_M = 0.2
# As image_transport's default.
_JPEG_QUALITY = 80


class CameraMount(NamedTuple):
    """Pose of a camera on the vehicle; positive pitch looks down."""

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float
    pitch_rad: float


class _Picture(Image):
    """An Image whose data is an array, which is written without the copies of each field."""

    def serialize(self, buff: IO[bytes]) -> None:
        fields = self.header, self.height, self.width, self.encoding, self.is_bigendian, self.step
        Image(*fields, b"").serialize(buff)
        buff.seek(-4, 1)  # back over the length of the empty last field
        buff.write(len(self.data).to_bytes(4, "little"))
        buff.write(self.data)


def image_message(picture: np.ndarray, stamp: rospy.Time, frame: str = "") -> Image:
    """Return a picture (H, W, 4) of BGRA uint8 as an Image, which shares its pixels."""
    (height, width), header = picture.shape[:2], Header(0, stamp, frame)
    pixels = memoryview(picture).cast("B")
    return _Picture(header, height, width, "bgra8", 0, 4 * width, pixels)


def compressed_message(picture: np.ndarray, stamp: rospy.Time, frame: str = "") -> CompressedImage:
    """Return a picture (H, W, 4) of BGRA uint8 as a JPEG, in the form of image_transport."""
    _, jpeg = cv2.imencode(".jpg", picture[:, :, :3], (cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY))
    form = "bgr8; jpeg compressed bgr8"
    return CompressedImage(Header(0, stamp, frame), form, jpeg.tobytes())


def camera_info_message(camera: CameraModel, frame: str = "") -> CameraInfo:
    """Return the description of a pinhole camera without distortion; the caller sets the stamp."""
    k = np.asarray(camera.intrinsic_matrix())
    message = CameraInfo(height=camera.height, width=camera.width, distortion_model="plumb_bob")
    message.header.frame_id = frame
    message.D, message.K, message.R = [0.0] * 5, k.ravel().tolist(), np.eye(3).ravel().tolist()
    message.P = np.column_stack([k, np.zeros(3)]).ravel().tolist()
    return message


def daylight(sun_altitude_deg: float) -> float:
    """Return the brightness 0..1 of the pictures for an altitude of the sun: its sine.

    Raises:
        ValueError: the altitude is not finite
    """
    if not math.isfinite(sun_altitude_deg):
        raise ValueError(f"sun_altitude_angle is {sun_altitude_deg}")
    return min(max(math.sin(math.radians(min(max(sun_altitude_deg, -90.0), 90.0))), 0.0), 1.0)


def spectator_mount(message: PoseStamped, vehicle_frame: str) -> CameraMount:
    """Return where a pose puts the spectator's camera on the vehicle.

    The axes of the pose are those of a camera in RViz: x right, y up, z backward. Roll is ignored.

    Raises:
        ValueError: the pose is in another frame, or as camera_mount
    """
    if message.header.frame_id != vehicle_frame:
        raise ValueError(f"its frame is '{message.header.frame_id}'; use {vehicle_frame}")
    return camera_mount(message.pose, (0.0, 0.0, -1.0))


def camera_mount(pose: Pose, view: Sequence[float] = (1.0, 0.0, 0.0)) -> CameraMount:
    """Return where a pose on the vehicle puts a camera that looks along an axis of the pose.

    Raises:
        ValueError: the orientation is not a unit quaternion, or the pose is beyond the limits
    """
    place, q = pose.position, unit(pose.orientation)
    forward, left, up = Rotation.from_quat([q.x, q.y, q.z, q.w]).apply(view).tolist()
    pitch = -math.asin(min(max(up, -1.0), 1.0))
    if not (
        max(abs(place.x), abs(place.y), abs(place.z)) <= _MAX_SPECTATOR_M
        and place.z >= _LEAST_SPECTATOR_HEIGHT_M
        and abs(pitch) <= _MAX_SPECTATOR_PITCH_RAD
    ):
        raise ValueError(
            f"position ({place.x:g}, {place.y:g}, {place.z:g}) m and pitch {pitch:.2f} rad; stay "
            f"within {_MAX_SPECTATOR_M:g} m, above {_LEAST_SPECTATOR_HEIGHT_M:g} m and within "
            f"{_MAX_SPECTATOR_PITCH_RAD:g} rad of the horizon"
        )
    return CameraMount(place.x, place.y, place.z, math.atan2(left, forward), pitch)
