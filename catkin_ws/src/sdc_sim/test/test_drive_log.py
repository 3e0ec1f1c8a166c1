"""The record of a drive that only the simulator writes."""

import json

import rospy
from sdc_msgs.msg import CarlaVehicleControl

from sdc_common.ros.odometry import odometry_message
from sdc_sim.physics.ackermann import AckermannTarget
from sdc_sim.physics.obstacles import CollisionEvent
from sdc_sim.physics.vehicle import VehicleState
from sdc_sim.ros.drive_log import DriveLog
from sdc_sim.simulation.snapshot import Snapshot


def observed(x_m, collisions=()):
    state = VehicleState()
    odometry = odometry_message(rospy.Time(), (x_m, 0.1 + 0.2, 0.0), (3.0, 0.0, 0.0))
    return Snapshot(4_050_000_000, state, state, (), (), collisions), odometry


def test_each_line_is_an_event_of_the_evaluator_with_all_digits(tmp_path):
    path = tmp_path / "events"
    log = DriveLog(str(path))
    log.add_observation(*observed(1.0 / 3.0, (CollisionEvent(7, 1.0, 2.0),)))
    command = CarlaVehicleControl(throttle=0.5, brake=0.25, steer=-1.0)
    command.header.stamp = rospy.Time(4, 50_000_000)
    log.add_command(command)
    log.add_target(4_050_000_000, AckermannTarget(0.1, speed_mps=8.0))
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert lines == [
        ["collision", 4_050_000_000, 7],
        ["odometry", 4_050_000_000, 1.0 / 3.0, 0.1 + 0.2, 0.0, 3.0],
        ["command", 4_050_000_000, 0.5, 0.25, -1.0],
        ["target", 4_050_000_000, 0.1, 0.0, 8.0, 0.0, 0.0],
    ]
