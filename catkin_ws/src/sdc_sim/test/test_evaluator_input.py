import io
import os

import numpy as np
import pytest
import rosbag
import rospy
import yaml
from ackermann_msgs.msg import AckermannDrive
from carla_msgs.msg import CarlaEgoVehicleControl
from nav_msgs.msg import Odometry
from referee_rules import RULES
from sdc_msgs.msg import (
    BaseWaypoint,
    CarlaVehicleControl,
    LocalPath,
    Obstacle,
    ObstacleArray,
    Path,
    Waypoint,
)

from sdc_common.ros.odometry import GROUND_TRUTH, odometry_message
from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.ros.evaluator_input import EvaluatorInput
from sdc_testing import load_script

PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
CONFIG = os.path.join(PACKAGE, "config")


def with_route(**arguments):
    evaluator_input = EvaluatorInput(Evaluator(RULES), **arguments)
    evaluator_input.route(Path([BaseWaypoint(float(x), 0.0) for x in range(11)]))
    return evaluator_input


def odometry_at(tick):
    return odometry_message(rospy.Time(0, 50_000_000 * tick), (0.0, 0.0, 0.0), (0.0, -3.0, 0.0))


def test_record_yaml_names_the_topics_of_the_referee_its_rules_and_those_of_viewers():
    with open(os.path.join(CONFIG, "record.yaml"), encoding="utf-8") as file:
        recorded = yaml.safe_load(file)["topics"]
    topics = EvaluatorInput(Evaluator(RULES)).topics
    assert {*topics, "/referee/rules", GROUND_TRUTH, "/tf", "/clock"} < set(recorded)
    # The simulation starts when the odometry is connected.
    assert recorded[-1] == EvaluatorInput(Evaluator(RULES)).evaluator.odometry_topic


def test_messages_become_a_drive():
    evaluator_input = with_route()
    evaluator_input.route(Path())
    odometry = odometry_at(1)
    assert evaluator_input.odometry(odometry)
    assert not evaluator_input.odometry(odometry)
    evaluator_input.local_path(LocalPath([Waypoint(0.0, 0.0, 4.0), Waypoint(1.0, 0.0, 9.0)]))
    evaluator_input.local_path(LocalPath([Waypoint(0.0, 0.0, float("nan"))]))
    evaluator_input.local_path(LocalPath())
    evaluator_input.command(CarlaVehicleControl(throttle=0.5, steer=-0.25, header=odometry.header))
    result = evaluator_input.evaluator.result()
    assert result.progress.samples[0].speed_mps == 3.0
    np.testing.assert_allclose([row[:2] for row in result.planned], [(0.0, 4.0)])
    np.testing.assert_allclose(result.rows[:, -3:], [(0.5, 0.0, -0.25)])


@pytest.mark.parametrize("converted", [False, True])
def test_ackermann_targets_answer_ticks_unless_a_node_turns_them_into_commands(converted):
    evaluator_input = with_route()
    for tick in range(1, 5):
        message = odometry_at(tick)
        evaluator_input.odometry(message)
        if converted:
            evaluator_input.command(CarlaVehicleControl(throttle=0.5, header=message.header))
        evaluator_input.target(AckermannDrive(speed=5.0))
    result = evaluator_input.evaluator.result()
    assert result.metrics["ticks_by_order"] == (0 if converted else 4)
    assert result.metrics["ticks_by_stamp"] == (4 if converted else 0)
    assert np.isnan(result.rows[:, -3:]).all() == (not converted)
    assert np.isnan(result.rows[:, -3:]).any() == (not converted)


@pytest.mark.parametrize("message_class", [CarlaVehicleControl, CarlaEgoVehicleControl])
def test_commands_of_every_bridge_are_read_as_their_publisher_defines_them(message_class):
    evaluator_input = with_route()
    odometry = odometry_at(1)
    evaluator_input.odometry(odometry)
    buffer = io.BytesIO()
    message_class(throttle=0.5, steer=-0.25, header=odometry.header).serialize(buffer)
    raw = rospy.AnyMsg().deserialize(buffer.getvalue())
    raw._connection_header = {"md5sum": message_class._md5sum, "type": message_class._type}
    evaluator_input.command(raw)
    np.testing.assert_allclose(evaluator_input.evaluator.result().rows[:, -3:], [(0.5, 0.0, -0.25)])


def test_command_of_an_unknown_type_is_refused():
    raw = rospy.AnyMsg()
    raw._connection_header = {"md5sum": Odometry._md5sum, "type": "nav_msgs/Odometry"}
    with pytest.raises(ValueError, match="its type is nav_msgs/Odometry; publish"):
        with_route().command(raw)


def test_topics_have_the_role_name_of_the_vehicle():
    topics = EvaluatorInput(Evaluator(RULES), role_name="hero").topics
    assert "/carla/hero/odometry" in topics
    assert not [topic for topic in topics if "ego_vehicle" in topic]


def test_path_and_obstacles_are_recorded_twice_a_second_without_numbers_that_are_not_finite():
    evaluator_input = with_route()
    path = LocalPath([Waypoint(float(x), 0.5, 4.0) for x in range(100)])
    path.waypoints[-1].v = float("nan")
    box = Obstacle(id=9, kind="car")
    box.pose.position.x, box.pose.orientation.w, box.size.x, box.size.y = 8.0, 1.0, 4.0, 2.0
    broken = Obstacle(id=10, kind="car")
    broken.pose.position.x = float("inf")
    for tick in range(1, 22):
        odometry = odometry_at(tick)
        evaluator_input.odometry(odometry)
        path.waypoints[0].x = 0.01 * tick
        evaluator_input.local_path(path)
        box.pose.position.y = 0.01 * tick
        evaluator_input.obstacles(ObstacleArray(obstacles=[box, broken], header=odometry.header))
    entries = evaluator_input.evaluator.result().scene
    assert [round(time_s, 3) for time_s, _ in entries["path"]] == [0.05, 0.55, 1.05]
    assert [row[0] for row in entries["path"][0][1]] == pytest.approx(
        [0.01, *range(8, 100, 8)], abs=1e-6
    )
    assert entries["obstacles"][1] == (pytest.approx(0.55), [(9, 8.0, 0.11, 0.0, 4.0, 2.0)])


def test_replay_measures_by_the_ground_truth_that_its_bag_contains(tmp_path):
    replay = load_script(os.path.join(PACKAGE, "scripts", "replay.py"))
    node = replay.Replay.__new__(replay.Replay)
    node.rules = RULES
    with rosbag.Bag(str(tmp_path / "drive.bag"), "w") as bag:
        path = Path([BaseWaypoint(float(x), 0.0) for x in range(11)])
        bag.write("/planner/mission_waypoints", path, rospy.Time(0, 1))
        for tick in range(1, 10):
            odometry = odometry_at(tick)
            bag.write(GROUND_TRUTH, odometry, odometry.header.stamp)
            odometry.pose.pose.position.y = 1.0  # the estimate of the car
            bag.write("/carla/ego_vehicle/odometry", odometry, odometry.header.stamp)
    with rosbag.Bag(str(tmp_path / "drive.bag")) as bag:
        assert node.evaluate(bag).result().metrics["cross_track_max_m"] == 0.0
