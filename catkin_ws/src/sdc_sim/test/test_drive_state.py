"""Tests of the state and the views of the manual control."""

import math

import numpy as np
import pytest
import rospy
from carla_msgs.msg import (
    CarlaCollisionEvent,
    CarlaEgoVehicleStatus,
    CarlaLaneInvasionEvent,
    CarlaWorldInfo,
)
from nav_msgs.msg import Odometry
from sdc_msgs.msg import LocalPath, Obstacle, ObstacleArray, Waypoint
from sensor_msgs.msg import Image

from sdc_sim.manual_control.drive_state import DriveState
from sdc_sim.manual_control.map_view import MapView
from sdc_sim.manual_control.views import ViewSelector
from sdc_sim.physics.vehicle import VehicleCommand
from sdc_sim.ros.message_conversion import image_message, quaternion_from_yaw


class Clock:
    def __init__(self):
        self.now_s = 100.0

    def __call__(self):
        return self.now_s


def odometry(x=3.0, stamp_s=7.0, orientation=None):
    message = Odometry()
    message.header.stamp = rospy.Time(stamp_s)
    message.pose.pose.position.x = x
    message.pose.pose.orientation = orientation or quaternion_from_yaw(0.5)
    message.twist.twist.linear.x = 6.0
    return message


def test_readings_combine_all_messages():
    clock = Clock()
    state = DriveState(3.0, clock)
    own_command = VehicleCommand(throttle=0.5)
    assert state.readings(own_command, manual=True, client_fps=30.0).command is own_command
    assert state.readings(own_command, manual=True, client_fps=30.0).x_m is None
    for _ in range(5):
        state.on_odometry(odometry())
        clock.now_s += 0.05
    status = CarlaEgoVehicleStatus()
    status.control.brake = 1.0
    state.on_status(status)
    state.on_world_info(CarlaWorldInfo(map_name="Town03"))
    readings = state.readings(own_command, manual=False, client_fps=30.0)
    assert (readings.x_m, readings.speed_mps, readings.time_s, readings.map_name) == (
        3.0,
        6.0,
        7.0,
        "Town03",
    )
    assert readings.yaw_rad == pytest.approx(0.5)
    assert readings.server_fps == pytest.approx(20.0)
    assert readings.command.brake == 1.0
    assert state.stamp == rospy.Time(7)


def test_invalid_odometry_is_refused_and_the_previous_pose_stays():
    state = DriveState(3.0, Clock())
    state.on_odometry(odometry())
    with pytest.raises(ValueError):
        state.on_odometry(odometry(x=math.nan))
    assert state.pose[0] == 3.0


def test_events_become_notices():
    clock = Clock()
    state = DriveState(3.0, clock)
    state.on_obstacles(ObstacleArray(obstacles=[Obstacle(id=9, kind="pedestrian")]))
    state.on_collision(CarlaCollisionEvent(other_actor_id=9))
    state.on_collision(CarlaCollisionEvent(other_actor_id=8))
    state.on_lane_invasion(CarlaLaneInvasionEvent(crossed_lane_markings=[2]))
    assert [text for text, _ in state.notices()] == [
        "Collision with pedestrian",
        "Collision with actor 8",
        "Crossed line: solid",
    ]
    clock.now_s += 3.0
    assert state.notices() == []


def test_views_cycle_through_pictures_and_map():
    state = DriveState(3.0, Clock())
    views = ViewSelector(["front", "mask"], MapView(0.1, 10.0))
    assert views.picture(state) is None
    picture = np.random.default_rng(1).integers(0, 255, (48, 64, 4), dtype=np.uint8)
    views.on_picture(image_message(picture, rospy.Time(1)), "front")
    np.testing.assert_array_equal(views.picture(state), picture[:, :, :3])
    views.select_next()
    assert (views.selected, views.picture(state)) == ("mask", None)
    views.on_picture(
        Image(height=2, width=3, step=3, encoding="mono8", data=bytes(range(6))), "mask"
    )
    np.testing.assert_array_equal(views.picture(state)[:, :, 1], [[0, 1, 2], [3, 4, 5]])
    views.select_next()
    assert (views.selected, views.picture(state)) == (ViewSelector.MAP, None)
    state.on_path(LocalPath([Waypoint(3.0, 0.0, 5.0), Waypoint(9.0, 0.0, 5.0)]))
    state.on_odometry(odometry())
    assert views.picture(state).shape == (480, 640, 3)
    views.select_next()
    assert views.selected == "front"


@pytest.mark.parametrize(
    "message",
    [
        Image(),
        Image(height=480, width=640, step=2560, encoding="bgra8", data=b"short"),
        Image(height=1, width=1, step=4, encoding="nonsense", data=b"1234"),
    ],
)
def test_invalid_picture_is_refused(message):
    views = ViewSelector(["front"], MapView(0.1, 10.0))
    views.on_picture(message, "front")
    with pytest.raises(ValueError, match="front"):
        views.picture(DriveState(3.0, Clock()))
