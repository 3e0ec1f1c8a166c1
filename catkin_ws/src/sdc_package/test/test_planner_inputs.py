"""Each odometry is planned for once, with the obstacles and traffic lights of its time."""

import math

import pytest
import rospy
from carla_msgs.msg import (
    CarlaTrafficLightInfo,
    CarlaTrafficLightInfoList,
    CarlaTrafficLightStatus,
    CarlaTrafficLightStatusList,
)
from nav_msgs.msg import Odometry
from planned_roads import SETTINGS
from sdc_msgs.msg import Obstacle, ObstacleArray

from sdc_common.planning.stop_line import GREEN, RED
from sdc_common.ros import refusal
from sdc_package.planner_inputs import PlannerInputs


def odometry(seconds):
    message = Odometry()
    message.header.stamp = rospy.Time.from_sec(seconds)
    return message


def obstacles(seconds, *xs, lights=()):
    message = ObstacleArray(traffic_lights=list(lights))
    message.header.stamp = rospy.Time.from_sec(seconds)
    for x in xs:
        obstacle = Obstacle(kind="car", speed=2.0)
        obstacle.pose.position.x = x
        obstacle.pose.orientation.w = 1.0
        obstacle.size.x, obstacle.size.y, obstacle.size.z = 4.0, 2.0, 1.5
        message.obstacles.append(obstacle)
    return message


class Record:
    """PlannerInputs, and each answered odometry with the obstacles that were known then."""

    def __init__(self, started=True):
        self.answers = []
        self.inputs = PlannerInputs(self.answer, SETTINGS.traffic_lights)
        if started:
            self.inputs.start()

    def answer(self, message):
        seen = [obstacle.x_m for obstacle in self.inputs.obstacles]
        self.answers.append((message.header.stamp.to_sec(), seen))


@pytest.mark.parametrize(
    ("events", "answers"),
    [
        # Without obstacles, the odometry does not wait.
        ("o1 b1", [(1.0, [])]),
        ("o1 o1", [(1.0, [])]),
        # With obstacles, it waits for those of its time, which may arrive before it.
        ("b1:30 o1 o1.05", [(1.0, [30.0])]),
        ("b1:30 o1 o1.05 b1.05:31", [(1.0, [30.0]), (1.05, [31.0])]),
        ("b1:30 o1 b1.05:31 o1.05", [(1.0, [30.0]), (1.05, [31.0])]),
        ("b1:30 o1.05 b1.05 o1.1", [(1.05, []), (1.1, [])]),
        # Overdue obstacles do not stop the planner.
        ("b1:30 o1.05 o1.1 o1.15", [(1.1, [30.0])]),
    ],
)
def test_odometry_is_answered_once_with_the_obstacles_of_its_time(events, answers):
    record = Record()
    for event in events.split():
        seconds, _, x = event[1:].partition(":")
        if event[0] == "o":
            record.inputs.add_odometry(odometry(float(seconds)))
        else:
            record.inputs.add_obstacles(obstacles(float(seconds), *([float(x)] if x else [])))
    assert record.answers == answers


def test_odometry_before_the_mission_is_answered_when_the_mission_arrives():
    record = Record(started=False)
    record.inputs.add_odometry(odometry(1.0))
    assert record.answers == []
    record.inputs.start()
    assert record.answers == [(1.0, [])]


def test_odometry_waits_for_stamped_traffic_lights_and_not_for_others():
    red = CarlaTrafficLightStatus(id=7, state=RED)
    record = Record()
    record.inputs.add_light_status(CarlaTrafficLightStatusList(traffic_lights=[red]))
    record.inputs.add_odometry(odometry(1.0))
    assert [stamp for stamp, _ in record.answers] == [1.0]
    record.inputs.add_obstacles(obstacles(1.0, lights=[red]))
    record.inputs.add_odometry(odometry(1.05))
    assert [stamp for stamp, _ in record.answers] == [1.0]
    green = CarlaTrafficLightStatus(id=7, state=GREEN)
    record.inputs.add_light_status(CarlaTrafficLightStatusList(traffic_lights=[green]))
    assert record.inputs.traffic_lights.states == {7: RED}
    record.inputs.add_obstacles(obstacles(1.05, lights=[green]))
    assert [stamp for stamp, _ in record.answers] == [1.0, 1.05]
    assert record.inputs.traffic_lights.states == {7: GREEN}


@pytest.fixture
def log(caplog, monkeypatch):
    """Return what is logged, with the first warning about each topic."""
    monkeypatch.setattr(refusal, "_last_warning_s", {})
    return caplog


def test_bad_obstacles_are_refused_and_their_odometry_is_answered_with_the_last_good_ones(log):
    record = Record()
    record.inputs.add_obstacles(obstacles(1.0, 30.0))
    record.inputs.add_odometry(odometry(1.05))
    record.inputs.add_obstacles(obstacles(1.05, math.nan))
    assert record.answers == [(1.05, [30.0])]
    assert "refused a message on /carla/ego_vehicle/obstacles: a number of an" in log.text


def test_bad_positions_of_traffic_lights_are_refused(log):
    light = CarlaTrafficLightInfo(id=7)
    light.transform.orientation.w = 1.0
    light.trigger_volume.size.x, light.trigger_volume.size.y = 1.0, 3.5
    inputs = PlannerInputs(lambda message: None, SETTINGS.traffic_lights)
    inputs.add_light_info(CarlaTrafficLightInfoList(traffic_lights=[light]))
    assert inputs.traffic_lights.lines[7].half_width_m == pytest.approx(1.75)
    light.transform.position.x = math.nan
    inputs.add_light_info(CarlaTrafficLightInfoList(traffic_lights=[light]))
    assert inputs.traffic_lights.lines[7].x_m == 0.0
    assert "refused a message on /carla/traffic_lights/info: " in log.text


def test_detected_obstacle_has_the_values_of_the_message():
    inputs = PlannerInputs(lambda message: None, SETTINGS.traffic_lights)
    message = obstacles(1.0, 30.0)
    message.obstacles[0].pose.orientation.z = math.sin(0.25)
    message.obstacles[0].pose.orientation.w = math.cos(0.25)
    inputs.add_obstacles(message)
    (seen,) = inputs.obstacles
    assert (seen.x_m, seen.y_m, seen.length_m, seen.width_m) == (30.0, 0.0, 4.0, 2.0)
    assert (seen.yaw_rad, seen.speed_mps) == (pytest.approx(0.5), 2.0)
