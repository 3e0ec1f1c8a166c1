"""Fault injection into a running drive: kill and suspend nodes, and record what the car does."""

import contextlib
import os
import signal
import xmlrpc.client

import numpy as np
import rosgraph
import rospy
from carla_msgs.msg import CarlaEgoVehicleStatus
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl, LocalPath

from sdc_common.geometry.route import Route
from sdc_common.processes import wait_until
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_package.odometry import pose_and_speed
from sdc_testing import MessageListener

EGO = "/carla/ego_vehicle"
TIMEOUT_S = 60.0
TICK_S = 0.05


def pid_of(node):
    """Return the process id of a node, None if it does not answer."""
    with contextlib.suppress(rosgraph.MasterException, OSError, xmlrpc.client.Error):
        uri = rosgraph.Master(rospy.get_name()).lookupNode(node)
        return xmlrpc.client.ServerProxy(uri).getPid(rospy.get_name())[2]
    return None


def kill(node):
    """Kill a node with SIGKILL; return its process id."""
    pid = wait_until(lambda: pid_of(node), TIMEOUT_S, node)
    os.kill(pid, signal.SIGKILL)
    return pid


def wait_for_restart(node, dead_pid):
    """Wait until another process has the name of a node that was killed."""
    wait_until(lambda: pid_of(node) not in (None, dead_pid), TIMEOUT_S, f"the restart of {node}")


@contextlib.contextmanager
def suspended(node):
    """Suspend a node for the duration of the block."""
    pid = wait_until(lambda: pid_of(node), TIMEOUT_S, node)
    os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(pid, signal.SIGCONT)


class DriveRecord:
    """The messages of a drive; times are simulated [s].

    Odometry whose child frame is `ignored_frame` is not recorded.
    """

    def __init__(self, waypoints_path, ignored_frame=None):
        self.route = Route(load_waypoints(waypoints_path))
        self.paths = MessageListener("/planner/local_waypoints", LocalPath)
        self.commands = MessageListener(EGO + "/vehicle_control_cmd", CarlaVehicleControl)
        self.odometry = MessageListener(
            EGO + "/odometry", Odometry, lambda odometry: odometry.child_frame_id != ignored_frame
        )
        self.status = MessageListener(EGO + "/vehicle_status", CarlaEgoVehicleStatus)
        self.odometry.wait_for(seconds=TIMEOUT_S)
        self.status.wait_for(seconds=TIMEOUT_S)

    def wait_for(self, condition, seconds=TIMEOUT_S):
        """Return the next odometry whose (x, y, yaw, speed) meets the condition."""
        return self.odometry.wait_for(
            lambda odometry: condition(*pose_and_speed(odometry)),
            seconds,
            after=len(self.odometry.messages),
        )

    def wait_for_speed(self, above_mps):
        return self.wait_for(lambda _x, _y, _yaw, speed: speed > above_mps)

    def now(self):
        return self.odometry.messages[-1].header.stamp.to_sec()

    def series(self, since=0.0):
        """Return (time, speed) of each odometry since a time, (n, 2)."""
        rows = [
            (message.header.stamp.to_sec(), pose_and_speed(message)[3])
            for message in list(self.odometry.messages)
        ]
        return np.array([row for row in rows if row[0] >= since])

    def braking_since(self, since, least_brake=0.01):
        """Return the seconds from a time until the brake was applied, None if it was not."""
        for status in list(self.status.messages):
            # A status contains the command of the tick before it.
            applied_at = status.header.stamp.to_sec() - TICK_S
            if applied_at >= since - 1e-6 and status.control.brake >= least_brake:
                return applied_at - since
        return None

    def stopped_since(self, since):
        """Return the seconds from a time until the car stopped, None if it did not."""
        series = self.series(since)
        still = series[series[:, 1] < 0.05]
        return still[0, 0] - since if len(still) else None

    def turning(self, since=0.0):
        """Return the lateral acceleration of each odometry since a time, (n,) [m/s^2]."""
        return np.array(
            [
                message.twist.twist.linear.x * message.twist.twist.angular.z
                for message in list(self.odometry.messages)
                if message.header.stamp.to_sec() >= since
            ]
        )

    def max_error_m(self, since=0.0):
        """Return the maximum distance of the car's centre from the route since a time."""
        whole = 0.0, 0.0, self.route.length_m
        return max(
            self.route.line.project(*pose_and_speed(message)[:2], *whole).distance_m
            for message in list(self.odometry.messages)
            if message.header.stamp.to_sec() >= since
        )
