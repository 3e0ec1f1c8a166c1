import importlib
import io
import math
import os

import numpy as np
import pytest
import rospy
from nav_msgs.msg import Odometry
from sdc_msgs.msg import BaseWaypoint, CarlaVehicleControl, LocalPath, Path, Waypoint
from visualization_msgs.msg import Marker

from sdc_common.ros.odometry import pose_and_speed
from sdc_common.ros.stop_lines import stop_lines
from sdc_sim.physics.obstacles import CollisionEvent, ObstaclePlan, Obstacles
from sdc_sim.physics.traffic_lights import TrafficLightPlan, TrafficLights
from sdc_sim.physics.vehicle import VehicleCommand, VehicleState
from sdc_sim.physics.vehicle_parameters import load_vehicle
from sdc_sim.ros.message_conversion import (
    collision_message,
    lane_invasion_message,
    light_info_message,
    light_status_message,
    markers_message,
    obstacles_message,
    odometry_message,
    status_message,
    vehicle_info_message,
    vehicle_transform,
)

TESLA = os.path.join(
    os.path.dirname(os.path.abspath(__file__)), "..", "config", "vehicles", "tesla_model3.yaml"
)
NOW = rospy.Time(7)
LIGHTS = TrafficLights(
    [
        TrafficLightPlan(50.0, 2.0, 0.5, (("red", 5.0),)),
        TrafficLightPlan(10.0, 0.0, 0.0, (("green", 5.0),)),
    ]
)
STATES = LIGHTS.states(0.0)


def test_control_has_the_md5_sum_of_the_bridge():
    assert CarlaVehicleControl._md5sum == "50204ce132bb8c412ae626da2714a5ea"


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
        ("carla_ros_bridge", "CarlaVehicleControl", "50204ce132bb8c412ae626da2714a5ea"),
        ("ackermann_msgs", "AckermannDrive", "3512e91b48d69674a0e86fadf1ea8231"),
    ],
)
def test_messages_have_the_md5_sums_of_the_originals(package, name, md5):
    assert getattr(importlib.import_module(package + ".msg"), name)._md5sum == md5


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


def received(message):
    """Return the message as a subscriber receives it."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return type(message)().deserialize(buffer.getvalue())


def test_status_has_speed_and_acceleration_in_the_map():
    state = VehicleState(
        yaw_rad=math.pi / 2,
        speed_mps=3.0,
        lateral_speed_mps=4.0,
        longitudinal_acceleration_mps2=2.0,
        lateral_acceleration_mps2=1.0,
    )
    message = received(status_message(state, VehicleCommand(0.25, -0.5, 0.125, True, True), NOW))
    assert message.velocity == 5.0
    np.testing.assert_allclose(
        (message.acceleration.linear.x, message.acceleration.linear.y), (-1.0, 2.0), atol=1e-12
    )
    control = message.control
    assert (
        control.throttle,
        control.steer,
        control.brake,
        control.hand_brake,
        control.reverse,
    ) == (0.25, -0.5, 0.125, True, True)
    assert (control.gear, message.header.frame_id, message.header.stamp) == (-1, "map", NOW)


def test_vehicle_info_has_the_parameters_of_the_vehicle():
    info = received(vehicle_info_message(load_vehicle(TESLA), "tesla_model3", "hero"))
    assert (info.type, info.rolename, info.mass, len(info.wheels)) == (
        "vehicle.tesla.model3",
        "hero",
        1845.0,
        4,
    )
    front_left, _, rear_left, rear_right = info.wheels
    assert math.isclose(front_left.max_steer_angle, math.radians(70.0), rel_tol=1e-4)
    assert rear_left.max_steer_angle == 0.0
    assert front_left.position.x - rear_left.position.x == 2.87
    assert rear_left.position.y == -rear_right.position.y > 0.0


def test_events_have_their_values():
    collision = received(collision_message(CollisionEvent(102, -5.0, 2.0), NOW))
    assert (collision.other_actor_id, collision.normal_impulse.x, collision.normal_impulse.y) == (
        102,
        -5.0,
        2.0,
    )
    invasion = received(lane_invasion_message([1, 2], NOW))
    assert list(invasion.crossed_lane_markings) == [
        invasion.LANE_MARKING_BROKEN,
        invasion.LANE_MARKING_SOLID,
    ]


def test_obstacles_and_markers_show_the_same():
    obstacles = Obstacles(
        [
            ObstaclePlan.stationary("car", 1.0, 2.0, 0.5),
            ObstaclePlan.stationary("pedestrian", 3.0, 4.0, 0.0),
        ]
    ).states
    message = received(obstacles_message(obstacles, STATES, NOW))
    assert message.header.stamp == NOW
    assert [(one.id, one.kind, one.pose.position.x, one.size.x) for one in message.obstacles] == [
        (101, "car", 1.0, 4.7),
        (102, "pedestrian", 3.0, 0.5),
    ]
    assert [(light.id, light.state) for light in message.traffic_lights] == [(1001, 0), (1002, 2)]
    markers = received(markers_message(obstacles, {7}, NOW)).markers
    assert [(marker.id, marker.action) for marker in markers] == [
        (7, Marker.DELETE),
        (101, Marker.ADD),
        (102, Marker.ADD),
    ]
    assert markers[1].pose.position.z == 0.5 * markers[1].scale.z


def test_lights_have_their_stop_line_and_their_colour():
    status = received(light_status_message(STATES))
    assert [(light.id, light.state) for light in status.traffic_lights] == [
        (1001, status.traffic_lights[0].RED),
        (1002, 2),
    ]
    info = received(light_info_message(LIGHTS.plans, STATES))
    lines = stop_lines(info)
    assert lines[1001] == pytest.approx((50.0, 2.0, 1.75))
    assert lines[1002] == pytest.approx((10.0, 0.0, 1.75))
    # The pole is beyond the line, to the right, and faces the traffic.
    pole = info.traffic_lights[1].transform
    assert pole.position.x > 12.0
    assert pole.position.y < -1.9
    assert abs(pole.orientation.z) == pytest.approx(1.0)
