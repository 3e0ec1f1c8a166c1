"""Objects, actors and control info as CARLA's bridge has them."""

import io
import math
import os
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import rospy
from derived_object_msgs.msg import Object, ObjectArray
from visualization_msgs.msg import Marker

from sdc_sim.physics.ackermann import AckermannTarget
from sdc_sim.physics.obstacles import ObstacleState
from sdc_sim.physics.traffic_lights import TrafficLightState
from sdc_sim.physics.vehicle import VehicleCommand, VehicleState
from sdc_sim.physics.vehicle_parameters import load_vehicle
from sdc_sim.road.opendrive import opendrive
from sdc_sim.ros.object_messages import (
    actor_list_message,
    control_info_message,
    ego_object,
    object_array,
    object_marker,
    obstacle_object,
)

NOW = rospy.Time(7)
CAR = ObstacleState(101, "car", 1.0, 2.0, math.pi / 2, 4.0, 1.8, 1.5, 6.0)
CONE = ObstacleState(102, "obstacle", 5.0, 6.0, 0.0, 0.4, 0.4, 0.8, 0.0)


@pytest.fixture(scope="module")
def tesla():
    folder = os.path.dirname(os.path.abspath(__file__))
    return load_vehicle(os.path.join(folder, "..", "config", "vehicles", "tesla_model3.yaml"))


def received(message):
    """Return the message as a subscriber receives it."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return type(message)().deserialize(buffer.getvalue())


def test_objects_have_pose_size_kind_and_twist_in_the_map(tesla):
    state = VehicleState(yaw_rad=math.pi / 2, speed_mps=3.0, yaw_rate_radps=0.5)
    objects = [
        ego_object(state, tesla, 1.5, NOW, 9),
        obstacle_object(CAR, NOW, 9),
        obstacle_object(CONE, NOW, 9),
    ]
    array = received(object_array(objects, NOW))
    assert isinstance(array, ObjectArray)
    own, car, cone = array.objects
    assert (array.header.frame_id, array.header.stamp, car.id) == ("map", NOW, 101)
    np.testing.assert_allclose((own.twist.linear.x, own.twist.linear.y), (0.0, 3.0), atol=1e-12)
    np.testing.assert_allclose((car.twist.linear.x, car.twist.linear.y), (0.0, 6.0), atol=1e-12)
    assert own.twist.angular.z == 0.5
    assert (car.classification, car.classification_age) == (Object.CLASSIFICATION_CAR, 9)
    assert tuple(car.shape.dimensions) == (4.0, 1.8, 1.5)
    assert not cone.object_classified


def test_markers_of_the_own_car_are_green():
    marker = received(object_marker(obstacle_object(CAR, NOW, 1)))
    assert (marker.type, marker.color.r, marker.pose.position.z) == (Marker.CUBE, 255.0, 0.75)
    own = obstacle_object(CAR._replace(id=1), NOW, 1)
    assert object_marker(own).color.g == 255.0


def test_actor_list_has_vehicle_obstacles_and_lights():
    light = TrafficLightState(7, 0, 0.0, 0.0, 0.0)
    actors = received(
        actor_list_message("vehicle.tesla.model3", "hero", [CAR, CONE], [light])
    ).actors
    assert [(one.id, one.type.split(".")[0], one.rolename) for one in actors] == [
        (1, "vehicle", "hero"),
        (101, "vehicle", ""),
        (102, "static", ""),
        (7, "traffic", ""),
    ]


def test_control_info_has_target_and_executed_command(tesla):
    state = VehicleState(speed_mps=-2.0)
    command = VehicleCommand(0.25, -0.5, 0.125)
    target = AckermannTarget(steering_angle_rad=0.3, speed_mps=-4.0)
    info = received(control_info_message(state, command, target, tesla, None, NOW))
    assert (info.output.throttle, info.output.steer, info.output.brake) == (0.25, -0.5, 0.125)
    assert info.target.steering_angle == pytest.approx(-0.3), "positive to the right"
    assert (info.target.speed_abs, info.current.speed, info.current.speed_abs) == (4.0, -2.0, 2.0)
    assert info.restrictions.max_steering_angle == pytest.approx(tesla.max_wheel_angle_rad)
    assert (
        received(control_info_message(state, command, None, tesla, None, NOW)).target.speed == 0.0
    )


def test_opendrive_has_the_length_and_the_lanes_of_the_route():
    route = np.array([[0.0, 0.0], [30.0, 40.0], [30.0, 40.0], [30.0, 50.0]])
    root = ElementTree.fromstring(opendrive('a "<route>"', route).encode())
    road = root.find("road")
    assert float(road.get("length")) == 60.0
    pieces = road.findall("planView/geometry")
    assert [float(one.get("s")) for one in pieces] == [0.0, 50.0]
    assert float(pieces[1].get("hdg")) == pytest.approx(math.pi / 2)
    assert float(road.find("lanes/laneOffset").get("a")) == 1.75
    assert [one.get("id") for one in road.iter("lane")] == ["1", "0", "-1"]
