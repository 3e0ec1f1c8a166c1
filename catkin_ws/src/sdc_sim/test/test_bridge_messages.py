"""The messages of the bridge show the simulation as CARLA's bridge does."""

import io
import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import rospy
from derived_object_msgs.msg import Object
from presets import TESLA
from visualization_msgs.msg import Marker

from sdc_common.driving import Command
from sdc_common.ros.conversion import stop_lines
from sdc_sim.physics.ackermann import AckermannTarget
from sdc_sim.physics.obstacles import ObstaclePlan, Obstacles
from sdc_sim.physics.traffic_lights import TrafficLightPlan
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.road.opendrive import opendrive
from sdc_sim.ros import bridge_messages
from sdc_sim.ros.bridge_messages import World, obstacle_marker
from sdc_sim.simulation.simulation import Simulation

COMMAND = Command(throttle=0.75, steer=-0.25)


@pytest.fixture
def world():
    """Return a car that turns left, one that drives north, a box and two lights."""
    car = ObstaclePlan("car", ((20.0, 2.0), (20.0, 200.0)), (4.0, 1.8, 1.5), speed_mps=6.0)
    obstacles = Obstacles([car, ObstaclePlan.stationary("obstacle", 30.0, 6.0, 0.0)])
    lights = [TrafficLightPlan(50.0, 2.0, 0.5, (("red", 60.0),))]
    lights.append(TrafficLightPlan(10.0, 0.0, 0.0, (("green", 60.0),)))
    simulation = Simulation(Vehicle(TESLA), 0.05, 1.0, obstacles=obstacles, lights=lights)
    for _ in range(40):
        simulation.step(COMMAND)
    return World(simulation, "hero", "tesla_model3")


def received(message):
    """Return the message as a subscriber receives it."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return type(message)().deserialize(buffer.getvalue())


def made(world, name):
    (message,) = getattr(bridge_messages, name)(world)
    return received(message)


def in_map(state, forward, left):
    c, s = math.cos(state.yaw_rad), math.sin(state.yaw_rad)
    return pytest.approx((c * forward - s * left, s * forward + c * left))


def test_status_has_speed_executed_command_and_acceleration_in_the_map(world):
    message, state = made(world, "vehicle_status"), world.snapshot.state
    assert message.velocity == pytest.approx(math.hypot(state.speed_mps, state.lateral_speed_mps))
    acceleration = message.acceleration.linear
    assert (acceleration.x, acceleration.y) == in_map(
        state, state.longitudinal_acceleration_mps2, state.lateral_acceleration_mps2
    )
    control = message.control
    assert (control.throttle, control.steer, control.brake) == (0.75, -0.25, 0.0)
    assert (control.hand_brake, control.reverse, control.gear) == (False, False, 1)
    assert (message.header.frame_id, message.header.stamp) == ("map", rospy.Time(2, 50_000_000))
    world.simulation.step(Command(reverse=True))
    assert made(world, "vehicle_status").control.gear == -1


def test_world_status_has_the_tick_and_the_mode(world):
    status = made(world, "world_status")
    assert status.frame == world.simulation.tick
    assert (status.synchronous_mode, status.synchronous_mode_running) == (False, True)
    assert status.fixed_delta_seconds == pytest.approx(0.05)


def test_vehicle_info_has_the_parameters_of_the_vehicle(world):
    info = made(world, "vehicle_info")
    assert (info.type, info.rolename) == ("vehicle.tesla.model3", "hero")
    assert (info.mass, len(info.wheels)) == (1845.0, 4)
    front_left, _, rear_left, rear_right = info.wheels
    assert front_left.max_steer_angle == pytest.approx(math.radians(70.0), rel=1e-4)
    assert rear_left.max_steer_angle == front_left.max_handbrake_torque == 0.0
    assert front_left.max_brake_torque > rear_left.max_brake_torque > 0.0
    assert front_left.position.x - rear_left.position.x == pytest.approx(2.87)
    assert rear_left.position.y == -rear_right.position.y > 0.0


def test_collision_has_the_obstacle_and_the_impulse(world):
    assert bridge_messages.collisions(world) == []
    world.simulation.place(26.0, 6.0, 0.0)
    while not world.snapshot.collisions:
        world.simulation.step(Command(throttle=1.0))
        assert world.simulation.tick < 200
    collision = made(world, "collisions")
    assert (collision.header.frame_id, collision.other_actor_id) == ("hero", 102)
    assert collision.normal_impulse.x < -100.0


def test_obstacles_lights_and_markers_show_the_same(world):
    observed = world.snapshot
    message = made(world, "obstacles")
    assert message.header.stamp == rospy.Time(2, 50_000_000)
    found = [(one.id, one.kind, one.size.x) for one in message.obstacles]
    assert found == [(101, "car", 4.0), (102, "obstacle", 1.0)]
    assert [(one.id, one.state) for one in message.traffic_lights] == [(1001, 0), (1002, 2)]
    assert made(world, "light_status").traffic_lights == message.traffic_lights
    marker = received(obstacle_marker(world, observed.obstacles[0]))
    assert (marker.ns, marker.id, marker.action) == ("obstacles", 101, Marker.ADD)
    assert marker.pose.position.z == 0.5 * marker.scale.z == 0.75


def test_lights_have_their_stop_line(world):
    info = made(world, "light_info")
    lines = stop_lines(info)
    assert lines[1001] == pytest.approx((50.0, 2.0, 1.75, 0.0))
    assert lines[1002] == pytest.approx((10.0, 0.0, 1.75, 0.0))
    # The pole is beyond the line, to the right, and faces the traffic.
    pole = info.traffic_lights[1].transform
    assert pole.position.x > 12.0
    assert pole.position.y < -1.9
    assert abs(pole.orientation.z) == pytest.approx(1.0)


def test_objects_have_pose_size_kind_and_twist_in_the_map(world):
    array, state = made(world, "all_objects"), world.snapshot.state
    own, car, box = array.objects
    assert (array.header.frame_id, own.id, car.id) == ("map", 1, 101)
    assert (own.pose.position.x, own.pose.position.y) == (state.x_m, state.y_m)
    assert (own.twist.linear.x, own.twist.linear.y) == in_map(
        state, state.speed_mps, state.lateral_speed_mps
    )
    assert own.twist.angular.z == state.yaw_rate_radps > 0.0
    assert (car.twist.linear.x, car.twist.linear.y) == pytest.approx((0.0, 6.0))
    assert (car.classification, car.classification_age) == (Object.CLASSIFICATION_CAR, 41)
    assert tuple(car.shape.dimensions) == (4.0, 1.8, 1.5)
    assert not box.object_classified
    assert made(world, "other_objects").objects == [car, box]
    markers = list(map(received, bridge_messages.object_markers(world)))
    assert [(one.color.r, one.color.g) for one in markers] == [(0, 255), (255, 0), (255, 0)]
    assert (markers[1].type, markers[1].pose.position.z) == (Marker.CUBE, 0.75)


def test_actor_list_has_vehicle_obstacles_and_lights(world):
    actors = made(world, "actor_list").actors
    found = [(one.id, one.type.split(".")[0], one.rolename) for one in actors]
    others = (101, "vehicle"), (102, "static"), (1001, "traffic"), (1002, "traffic")
    assert found == [(1, "vehicle", "hero"), *((*other, "") for other in others)]


def test_control_info_has_target_and_executed_command(world):
    info = made(world, "control_info")
    assert (info.output.throttle, info.output.steer, info.output.brake) == (0.75, -0.25, 0.0)
    assert (info.target.speed, info.state.status) == (0.0, "n/a")
    assert info.current.speed == pytest.approx(world.snapshot.state.speed_mps)
    world.simulation.step(AckermannTarget(steering_angle_rad=0.3, speed_mps=-4.0))
    info = made(world, "control_info")
    assert info.target.steering_angle == pytest.approx(-0.3), "positive to the right"
    assert (info.target.speed_abs, info.state.status) == (4.0, "driving")
    assert info.restrictions.max_steering_angle == pytest.approx(TESLA.max_wheel_angle_rad)


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
