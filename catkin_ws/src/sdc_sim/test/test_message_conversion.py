"""Messages have the definitions of the originals, and odometry that of the state."""

import importlib
import math

import pytest
import rospy
from nav_msgs.msg import Odometry
from sdc_msgs.msg import BaseWaypoint, LocalPath, Path, Waypoint

from sdc_common.ros.odometry import pose_and_speed, vehicle_transform
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.ros.message_conversion import odometry_message


# MD5 sums of the packages' releases: nodes built against these connect.
@pytest.mark.parametrize(
    ("package", "name", "md5"),
    [
        ("carla_msgs", "CarlaEgoVehicleControl", "e5b57fc698c12ff4c20a5fc71fba832f"),
        ("carla_msgs", "CarlaTrafficLightStatusList", "99769ac9a785c6de87ed86d7bb4a653a"),
        ("carla_msgs", "CarlaTrafficLightInfoList", "d1e03fe534c61bfaafc4dfce64de368a"),
        ("carla_msgs", "CarlaEgoVehicleStatus", "7d24d9cd2c1c81e9a2b845b347cb2162"),
        ("carla_msgs", "CarlaEgoVehicleInfo", "7635942a53dfdf0edbbafc9eea467602"),
        ("carla_msgs", "CarlaEgoVehicleInfoWheel", "192cba6d0621954855f8c957508a83b4"),
        ("carla_msgs", "CarlaCollisionEvent", "9f08ee4a25bac7157d460b45684dd2b7"),
        ("carla_msgs", "CarlaLaneInvasionEvent", "3846cea49c4897522899dbda091314e8"),
        ("carla_msgs", "CarlaWorldInfo", "7a3a7a7fc8c213a8bec2ce7928b0a46c"),
        ("carla_msgs", "CarlaStatus", "0a6e668a0d517dead8f5c68762fc1dab"),
        ("carla_msgs", "CarlaActorList", "a10ababa303f55dd50f485b995641f71"),
        ("carla_msgs", "CarlaMapInfo", "13896e12d449662e7a6dbaeb31ad882a"),
        ("carla_msgs", "CarlaWeatherParameters", "bb273e4588ee8778c1dac74839d4709e"),
        ("carla_msgs", "CarlaActorInfo", "101ec1019fd4e4a480a106d5c6d5dcac"),
        ("carla_msgs", "CarlaBoundingBox", "17746d0996c54d9b8b0dfe6f3cd0b588"),
        ("carla_msgs", "CarlaControl", "30f228b2c28301e4ee4bc6cc67050acb"),
        ("carla_msgs", "CarlaGnssRoute", "49ad7223bd993f45a26acbd418f45289"),
        ("carla_msgs", "CarlaRoute", "bc670453c2048b5a51c59f0ca05b007d"),
        ("carla_msgs", "CarlaSpeedometer", "17b1dfb61067b5181d2fbfcebd547b10"),
        ("carla_msgs", "CarlaTrafficLightInfo", "c303b00d6ff9db591d60b1662aec9d48"),
        ("carla_msgs", "CarlaTrafficLightStatus", "efe41b78c4438f29488e7ecfe6631a9b"),
        ("carla_msgs", "CarlaWalkerControl", "bd3de0306de3de4e7161a29868c1f9a7"),
        ("carla_msgs", "DestroyObject", "f66e2f1a2389241ede90395037adaed8"),
        ("carla_msgs", "GetBlueprints", "8c8fca221e4d3a2dbeec92f6b3d2eda4"),
        ("carla_msgs", "SpawnObject", "e33e3f6271c805c5651cbf682dacbcbd"),
        ("sdc_msgs", "CarlaVehicleControl", "50204ce132bb8c412ae626da2714a5ea"),
        ("carla_ros_bridge", "CarlaVehicleControl", "50204ce132bb8c412ae626da2714a5ea"),
        ("ackermann_msgs", "AckermannDrive", "3512e91b48d69674a0e86fadf1ea8231"),
    ],
)
def test_messages_have_the_md5_sums_of_the_originals(package, name, md5):
    kind = "msg" if name.startswith(("Carla", "Ackermann")) else "srv"
    assert getattr(importlib.import_module(f"{package}.{kind}"), name)._md5sum == md5


def test_messages_have_the_fields_of_the_contract():
    assert (BaseWaypoint.__slots__, BaseWaypoint._slot_types) == (
        ["x", "y"],
        ["float32", "float32"],
    )
    assert (Waypoint.__slots__, Waypoint._slot_types) == (["x", "y", "v"], ["float32"] * 3)
    assert (Path.__slots__, LocalPath.__slots__) == (["waypoints"], ["waypoints"])


def test_odometry_message_returns_the_state():
    state = VehicleState(
        x_m=1.0, y_m=-2.0, yaw_rad=2.5, speed_mps=3.0, lateral_speed_mps=4.0, yaw_rate_radps=0.5
    )
    message = odometry_message(state, rospy.Time(7))
    x, y, yaw, speed = pose_and_speed(message)
    assert (x, y, speed) == (1.0, -2.0, 5.0)
    assert math.isclose(yaw, 2.5)
    assert (message.twist.twist.linear.x, message.twist.twist.linear.y) == (3.0, 4.0)
    assert message.twist.twist.angular.z == 0.5
    transform = vehicle_transform(message)
    assert (transform.header.frame_id, transform.child_frame_id) == ("map", "ego_vehicle")
    assert transform.transform.rotation == message.pose.pose.orientation
    assert isinstance(message, Odometry)
