"""What the fault tests share: finding, killing and stopping real nodes, and watching the car meanwhile."""

import contextlib
import os
import signal
import xmlrpc.client

import numpy as np
import rosgraph
import rospy
from carla_msgs.msg import CarlaEgoVehicleStatus
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sdc_package.msg import CarlaVehicleControl, LocalPath

from sdc_common.geometry.route import Route
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_common.testing.message_listener import MessageListener, wait_until
from sdc_package.odometry import pose_and_speed

EGO = "/carla/ego_vehicle"
PATIENCE_S = 60.0
TICK_S = 0.05


def pid_of(node):
    """The process number of a running node, None while it does not answer."""
    with contextlib.suppress(rosgraph.MasterException, OSError, xmlrpc.client.Error):
        return xmlrpc.client.ServerProxy(rosgraph.Master(rospy.get_name()).lookupNode(node)).getPid(
            rospy.get_name()
        )[2]
    return None


def kill(node):
    """Kill a node as the system would; returns the number of the dead process."""
    pid = wait_until(lambda: pid_of(node), PATIENCE_S, f"{node} to be there")
    os.kill(pid, signal.SIGKILL)
    return pid


def wait_for_return(node, dead_pid):
    """Wait until another process answers in the place of a dead one."""
    wait_until(lambda: pid_of(node) not in (None, dead_pid), PATIENCE_S, f"{node} to come back")


@contextlib.contextmanager
def stopped(node):
    """A node that neither runs nor ends meanwhile."""
    pid = wait_until(lambda: pid_of(node), PATIENCE_S, f"{node} to be there")
    os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(pid, signal.SIGCONT)


class Watch:
    """Hears all of a drive; times are those of the simulation, in seconds. Odometry whose child frame is `ignored_frame` is left out."""

    def __init__(self, waypoints_path, ignored_frame=None):
        self.route = Route(load_waypoints(waypoints_path))
        self.clock = MessageListener("/clock", Clock)
        self.paths = MessageListener("/planner/local_waypoints", LocalPath)
        self.commands = MessageListener(EGO + "/vehicle_control_cmd", CarlaVehicleControl)
        self.odometry = MessageListener(
            EGO + "/odometry", Odometry, lambda odometry: odometry.child_frame_id != ignored_frame
        )
        self.status = MessageListener(EGO + "/vehicle_status", CarlaEgoVehicleStatus)
        self.odometry.wait_for(seconds=PATIENCE_S)
        self.status.wait_for(seconds=PATIENCE_S)

    def wait_for(self, condition, seconds=PATIENCE_S):
        """The first odometry from now on whose (x, y, yaw, speed) fulfils the condition."""
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
        """(time, speed) of the odometry heard since then: (n, 2)."""
        rows = [
            (message.header.stamp.to_sec(), pose_and_speed(message)[3])
            for message in list(self.odometry.messages)
        ]
        return np.array([row for row in rows if row[0] >= since])

    def braking_since(self, since, least_brake=0.01):
        """Seconds from `since` until the car obeyed the brake, None if it did not."""
        for status in list(self.status.messages):
            # A status shows the command of the tick that led to it.
            obeyed_at = status.header.stamp.to_sec() - TICK_S
            if obeyed_at >= since - 1e-6 and status.control.brake >= least_brake:
                return obeyed_at - since
        return None

    def stopped_since(self, since):
        """Seconds from `since` until the car stood, None if it did not."""
        series = self.series(since)
        still = series[series[:, 1] < 0.05]
        return still[0, 0] - since if len(still) else None

    def turning(self, since=0.0):
        """Lateral acceleration of the odometry heard since then, m/s^2: (n,)."""
        return np.array(
            [
                message.twist.twist.linear.x * message.twist.twist.angular.z
                for message in list(self.odometry.messages)
                if message.header.stamp.to_sec() >= since
            ]
        )

    def worst_error_m(self, since=0.0):
        """Farthest that the car's centre has come off the route's line since then, wherever along it."""
        whole = 0.0, 0.0, self.route.length_m
        return max(
            self.route.project(*pose_and_speed(message)[:2], *whole).distance_m
            for message in list(self.odometry.messages)
            if message.header.stamp.to_sec() >= since
        )

    def clock_went_back(self):
        """Whether any tick of the clock was before the one heard before it."""
        ticks = [message.clock.to_nsec() for message in list(self.clock.messages)]
        return any(after < before for before, after in zip(ticks, ticks[1:]))
