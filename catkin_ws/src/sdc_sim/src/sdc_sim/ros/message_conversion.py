"""Turns the numbers of the world into ROS messages."""

from __future__ import annotations

import math
import os
import struct
from typing import TYPE_CHECKING

import numpy as np
from carla_msgs.msg import (
    CarlaBoundingBox,
    CarlaCollisionEvent,
    CarlaEgoVehicleControl,
    CarlaEgoVehicleInfo,
    CarlaEgoVehicleInfoWheel,
    CarlaEgoVehicleStatus,
    CarlaLaneInvasionEvent,
    CarlaTrafficLightInfo,
    CarlaTrafficLightInfoList,
    CarlaTrafficLightStatus,
    CarlaTrafficLightStatusList,
)
from geometry_msgs.msg import Point, Pose, Quaternion, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from sdc_msgs.msg import Obstacle, ObstacleArray
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from sdc_sim.physics.traffic_lights import LANE_WIDTH_M
from sdc_sim.physics.vehicle import VehicleCommand, VehicleParameters, VehicleState

if TYPE_CHECKING:
    from sdc_sim.camera.camera_model import CameraModel

MAP_FRAME = "map"
VEHICLE_FRAME = "ego_vehicle"
CAMERA_FRAME = "ego_vehicle/camera/rgb/front"
EGO_ID = 1

# What the model of the car has no figure for, and readers of vehicle_info may divide by.
_NOMINAL_WHEEL_RADIUS_M = 0.35
_NOMINAL_TRACK_SHARE = 0.8
# Length along the lane and height of a traffic light's trigger volume.
_LINE_DEPTH_M = 1.0
_LINE_HEIGHT_M = 2.0
# Red, green, blue of each kind of obstacle, in the camera as in RViz.
COLOURS = {
    "car": (0.63, 0.16, 0.16),
    "pedestrian": (0.13, 0.31, 0.67),
    "obstacle": (0.9, 0.55, 0.1),
}


def quaternion_from_yaw(yaw_rad: float) -> Quaternion:
    """The orientation of a body turned counter-clockwise from the x axis."""
    return Quaternion(0.0, 0.0, math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad))


def odometry_message(state: VehicleState, stamp) -> Odometry:
    """Pose of the car's centre in the map, twist in the body frame."""
    message = Odometry()
    message.header.stamp = stamp
    message.header.frame_id = MAP_FRAME
    message.child_frame_id = VEHICLE_FRAME
    pose = message.pose.pose
    pose.position.x = state.x_m
    pose.position.y = state.y_m
    pose.orientation = quaternion_from_yaw(state.yaw_rad)
    twist = message.twist.twist
    twist.linear.x = state.speed_mps
    twist.linear.y = state.lateral_speed_mps
    twist.angular.z = state.yaw_rate_radps
    return message


def vehicle_transform(odometry: Odometry) -> TransformStamped:
    """The transform map -> ego_vehicle of an odometry message."""
    transform = TransformStamped()
    transform.header = odometry.header
    transform.child_frame_id = VEHICLE_FRAME
    transform.transform.translation.x = odometry.pose.pose.position.x
    transform.transform.translation.y = odometry.pose.pose.position.y
    transform.transform.rotation = odometry.pose.pose.orientation
    return transform


def camera_transform(camera: CameraModel) -> TransformStamped:
    """The fixed transform ego_vehicle -> camera optical frame (z forward, x right, y down: REP 103)."""
    half = 0.5 * camera.pitch_rad
    transform = TransformStamped()
    transform.header.frame_id = VEHICLE_FRAME
    transform.child_frame_id = CAMERA_FRAME
    transform.transform.translation.x = camera.mount_x_m
    transform.transform.translation.z = camera.mount_z_m
    # The optical frame's quaternion (-0.5, 0.5, -0.5, 0.5), after a turn about the body's y axis by the pitch.
    c, s = 0.5 * math.cos(half), 0.5 * math.sin(half)
    transform.transform.rotation = Quaternion(-c - s, c + s, s - c, c - s)
    return transform


class PictureMessage(Image):
    """An Image whose `data` is a flat memoryview: it is serialised without the copies that bytes would cost."""

    def serialize(self, buff) -> None:
        """Write it as an Image is written."""
        pixels, self.data = self.data, b""
        super().serialize(buff)
        self.data = pixels
        buff.seek(-4, os.SEEK_CUR)  # the length of no data
        buff.write(struct.pack("<I", len(pixels)))
        buff.write(pixels)


def image_message(picture: np.ndarray, stamp) -> Image:
    """A contiguous (H, W, 4) BGRA uint8 picture as an Image; to be published before the picture changes."""
    message = PictureMessage()
    message.header.stamp = stamp
    message.header.frame_id = CAMERA_FRAME
    message.height, message.width = picture.shape[:2]
    message.encoding = "bgra8"
    message.step = picture.shape[1] * 4
    message.data = memoryview(picture).cast("B")
    return message


def camera_info_message(camera: CameraModel) -> CameraInfo:
    """The pinhole camera without distortion; the stamp is left to set."""
    k = np.asarray(camera.intrinsic_matrix())
    message = CameraInfo(height=camera.height, width=camera.width, distortion_model="plumb_bob")
    message.header.frame_id = CAMERA_FRAME
    message.D = [0.0] * 5
    message.K = k.ravel().tolist()
    message.R = np.eye(3).ravel().tolist()
    message.P = np.column_stack([k, np.zeros(3)]).ravel().tolist()
    return message


def status_message(state: VehicleState, command: VehicleCommand, stamp) -> CarlaEgoVehicleStatus:
    """How the car moves; its acceleration in the map, as the bridge gives it."""
    message = CarlaEgoVehicleStatus(header=Header(stamp=stamp, frame_id=MAP_FRAME))
    message.velocity = math.hypot(state.speed_mps, state.lateral_speed_mps)
    c, s = math.cos(state.yaw_rad), math.sin(state.yaw_rad)
    forward, left = state.longitudinal_acceleration_mps2, state.lateral_acceleration_mps2
    message.acceleration.linear = Vector3(c * forward - s * left, s * forward + c * left, 0.0)
    message.orientation = quaternion_from_yaw(state.yaw_rad)
    message.control = CarlaEgoVehicleControl(
        header=message.header,
        throttle=command.throttle,
        steer=command.steer,
        brake=command.brake,
        hand_brake=command.hand_brake,
        reverse=command.reverse,
        gear=-1 if command.reverse else 1,
    )
    return message


def vehicle_info_message(
    parameters: VehicleParameters, preset: str, role_name: str
) -> CarlaEgoVehicleInfo:
    """What the car is. Its motor and gears have no figures here: those fields are zero."""
    p = parameters
    track_m = _NOMINAL_TRACK_SHARE * p.width_m
    radius_m = _NOMINAL_WHEEL_RADIUS_M
    message = CarlaEgoVehicleInfo(
        id=EGO_ID,
        type="vehicle." + preset.replace("_", ".", 1),
        rolename=role_name,
        mass=p.mass_kg,
        drag_coefficient=p.drag_area_m2,
        use_gear_autobox=True,
    )
    message.center_of_mass.z = p.cg_height_m
    brakes_n = (
        p.brake_force_n * p.brake_front_share,
        p.brake_force_n * (1.0 - p.brake_front_share),
    )
    for front in (True, False):
        for left in (True, False):
            message.wheels.append(
                CarlaEgoVehicleInfoWheel(
                    tire_friction=p.tyre_friction,
                    radius=radius_m,
                    max_steer_angle=p.max_wheel_angle_rad if front else 0.0,
                    max_brake_torque=0.5 * radius_m * brakes_n[0 if front else 1],
                    max_handbrake_torque=0.0 if front else 0.5 * radius_m * p.hand_brake_force_n,
                    position=Vector3(
                        p.front_axle_m if front else -p.rear_axle_m,
                        0.5 * track_m if left else -0.5 * track_m,
                        radius_m,
                    ),
                )
            )
    return message


def collision_message(touch, stamp) -> CarlaCollisionEvent:
    """A Touch as an event."""
    return CarlaCollisionEvent(
        header=Header(stamp=stamp, frame_id=VEHICLE_FRAME),
        other_actor_id=touch.id,
        normal_impulse=Vector3(touch.impulse_x_ns, touch.impulse_y_ns, 0.0),
    )


def lane_invasion_message(lines, stamp) -> CarlaLaneInvasionEvent:
    """The kinds of lines that the car has begun to cross as an event."""
    return CarlaLaneInvasionEvent(
        header=Header(stamp=stamp, frame_id=VEHICLE_FRAME), crossed_lane_markings=lines
    )


def obstacles_message(bodies, lamps, stamp) -> ObstacleArray:
    """The ground truth of the obstacles, and of what the traffic lights show."""
    return ObstacleArray(
        Header(stamp=stamp, frame_id=MAP_FRAME),
        [
            Obstacle(
                body.id,
                body.kind,
                Pose(Point(body.x_m, body.y_m, 0.0), quaternion_from_yaw(body.yaw_rad)),
                Vector3(body.length_m, body.width_m, body.height_m),
                body.speed_mps,
            )
            for body in bodies
        ],
        [CarlaTrafficLightStatus(lamp.id, lamp.state) for lamp in lamps],
    )


def light_status_message(lamps) -> CarlaTrafficLightStatusList:
    """What every traffic light shows."""
    return CarlaTrafficLightStatusList(
        [CarlaTrafficLightStatus(lamp.id, lamp.state) for lamp in lamps]
    )


def light_info_message(lights, lamps) -> CarlaTrafficLightInfoList:
    """Where the traffic lights stand. The middle of a trigger volume is the middle of the stop line, a lane wide."""
    infos = []
    for light, lamp in zip(lights, lamps):
        yaw = lamp.heading_rad + math.pi
        c, s = math.cos(yaw), math.sin(yaw)
        east, north = light.x_m - lamp.x_m, light.y_m - lamp.y_m
        centre = Vector3(c * east + s * north, c * north - s * east, 0.0)
        infos.append(
            CarlaTrafficLightInfo(
                lamp.id,
                Pose(Point(lamp.x_m, lamp.y_m, 0.0), quaternion_from_yaw(yaw)),
                CarlaBoundingBox(centre, Vector3(_LINE_DEPTH_M, LANE_WIDTH_M, _LINE_HEIGHT_M)),
            )
        )
    return CarlaTrafficLightInfoList(infos)


def markers_message(bodies, gone, stamp) -> MarkerArray:
    """The obstacles as boxes for RViz; `gone` are the numbers of those that are there no more."""
    header = Header(stamp=stamp, frame_id=MAP_FRAME)
    markers = [
        Marker(header=header, ns="obstacles", id=number, action=Marker.DELETE)
        for number in sorted(gone)
    ]
    for body in bodies:
        markers.append(
            Marker(
                header=header,
                ns="obstacles",
                id=body.id,
                type=Marker.CUBE,
                action=Marker.ADD,
                pose=Pose(
                    Point(body.x_m, body.y_m, 0.5 * body.height_m),
                    quaternion_from_yaw(body.yaw_rad),
                ),
                scale=Vector3(body.length_m, body.width_m, body.height_m),
                color=ColorRGBA(*COLOURS[body.kind], 1.0),
            )
        )
    return MarkerArray(markers)
