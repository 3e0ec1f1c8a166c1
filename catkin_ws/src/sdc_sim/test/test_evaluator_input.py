"""What the referee hears, what is recorded, and what a replay listens to are the same."""

import os
import re

import numpy as np
import pytest
import yaml
from nav_msgs.msg import Odometry
from sdc_msgs.msg import BaseWaypoint, CarlaVehicleControl, LocalPath, Path, Waypoint

from sdc_sim.evaluation.evaluator import EvaluationRules, Evaluator
from sdc_sim.ros.evaluator_input import EvaluatorInput

PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
with open(
    os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "config", "referee.yaml"),
    encoding="utf-8",
) as config:
    RULES = EvaluationRules.read(yaml.safe_load(config).get)


def test_all_that_is_heard_is_recorded_and_nothing_else_is():
    with open(os.path.join(PACKAGE, "config", "record.yaml"), encoding="utf-8") as file:
        recorded = yaml.safe_load(file)["topics"]
    with open(os.path.join(PACKAGE, "scripts", "referee.py"), encoding="utf-8") as file:
        subscribed = re.findall(r'Subscriber\("([^"]+)"', file.read())
    assert sorted(EvaluatorInput(Evaluator(RULES)).by_topic) == sorted(subscribed)
    assert sorted(recorded) == sorted([*subscribed, "/referee/rules"])


def test_messages_become_a_drive():
    hearing = EvaluatorInput(Evaluator(RULES))
    hearing.mission(Path([BaseWaypoint(float(x), 0.0) for x in range(11)]))
    hearing.mission(Path())
    odometry = Odometry()
    odometry.header.stamp.nsecs = 50_000_000
    odometry.pose.pose.orientation.w = 1.0
    odometry.twist.twist.linear.y = -3.0
    assert hearing.odometry(odometry)
    assert not hearing.odometry(odometry)
    hearing.local_path(LocalPath([Waypoint(0.0, 0.0, 4.0), Waypoint(1.0, 0.0, 9.0)]))
    hearing.local_path(LocalPath([Waypoint(0.0, 0.0, float("nan"))]))
    hearing.local_path(LocalPath())
    hearing.command(CarlaVehicleControl(throttle=0.5, steer=-0.25, header=odometry.header))
    result = hearing.watch.result()
    assert result.drive.samples[0].speed_mps == 3.0
    np.testing.assert_allclose(result.planned, [(0.0, 4.0)])
    np.testing.assert_allclose(result.commands, [(0.5, 0.0, -0.25)])


def test_what_is_no_number_is_refused():
    hearing = EvaluatorInput(Evaluator(RULES))
    hearing.mission(Path([BaseWaypoint(float(x), 0.0) for x in range(11)]))
    odometry = Odometry()
    odometry.pose.pose.orientation.w = 1.0
    odometry.pose.pose.position.x = float("nan")
    with pytest.raises(ValueError, match="finite"):
        hearing.odometry(odometry)
