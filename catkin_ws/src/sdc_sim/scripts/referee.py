#!/usr/bin/env python3
"""Referee: follows the drive along the route, tells how it goes, and writes the report when it ends."""
import os
import sys
import threading
import time

import numpy as np
import rospy
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl, Path

from sdc_package.node import parameter, refuse
from sdc_package.odometry import pose_and_speed
from sdc_package.planning import SpeedLimits, ideal_duration, speed_profile
from sdc_package.route import Route
from sdc_sim.answers import Answers
from sdc_sim.drive import COMPLETED, Drive, DriveLimits
from sdc_sim.report import ReportError, check_writable, write_report

# The names under which the local planner knows its limits: what the ideal duration is reckoned with.
PLANNER_LIMITS = {"cruise_mps": "planned_speed_mps", "lateral_mps2": "lateral_acceleration_mps2",
                  "acceleration_mps2": "acceleration_mps2", "braking_mps2": "braking_mps2", "lateral_jerk_mps3": "lateral_jerk_mps3"}
LAST_ANSWERS_S = 1.0


class Referee:
    def __init__(self):
        rospy.init_node("referee")
        self.report_path = os.path.expanduser(parameter("report"))
        self.limits = {name: parameter(name) for name in ("off_route_m", "blocked_s", "finish_within_m")}
        self.timeout_ratio = parameter("timeout_ratio")
        self.timeout_margin_s = parameter("timeout_margin_s")
        try:
            check_writable(self.report_path)
        except ReportError as error:
            refuse(error)

        self.lock = threading.Lock()
        self.ended = threading.Event()
        self.drive = None
        self.ideal_duration_s = None
        self.answers = Answers()
        self.early_odometry = []
        self.started_at = self.ended_at = None

        rospy.Subscriber("/planner/mission_waypoints", Path, self.on_mission, queue_size=1)
        rospy.Subscriber("/carla/ego_vehicle/odometry", Odometry, self.on_odometry, tcp_nodelay=True)
        rospy.Subscriber("/carla/ego_vehicle/vehicle_control_cmd", CarlaVehicleControl, self.on_command, tcp_nodelay=True)

    def on_mission(self, path):
        with self.lock:
            if self.drive is not None:
                return
            try:
                route = Route(np.array([(point.x, point.y) for point in path.waypoints]).reshape(-1, 2))
                profile_limits = SpeedLimits(**{ours: rospy.get_param("/local_planner/" + theirs)
                                                for ours, theirs in PLANNER_LIMITS.items()})
            except (KeyError, TypeError, ValueError) as error:
                rospy.logerr("referee: cannot judge the mission on /planner/mission_waypoints: %s", error)
                return
            self.ideal_duration_s = ideal_duration(route, speed_profile(route, profile_limits))
            timeout_s = self.timeout_ratio * self.ideal_duration_s + self.timeout_margin_s
            self.drive = Drive(route, DriveLimits(timeout_s=timeout_s, **self.limits))
            for odometry in self.early_odometry:
                self.follow(odometry)
            self.early_odometry = []

    def on_odometry(self, odometry):
        with self.lock:
            if self.drive is None:
                self.early_odometry.append(odometry)
            else:
                self.follow(odometry)

    def on_command(self, command):
        with self.lock:
            self.answers.answer(command.header.stamp.to_nsec())

    def follow(self, odometry):
        stamp = odometry.header.stamp
        if self.drive.status is not None or not self.answers.ask(stamp.to_nsec()):
            return
        if len(self.drive.samples) < 2:
            self.started_at = time.monotonic()
        try:
            self.drive.update(stamp.to_sec(), *pose_and_speed(odometry))
        except ValueError as error:
            rospy.logwarn_throttle(1.0, f"referee: left out an odometry on /carla/ego_vehicle/odometry: {error}")
        self.ended_at = time.monotonic()
        if self.drive.status is not None:
            self.ended.set()

    def say_progress(self):
        with self.lock:
            if self.drive is None or not self.drive.samples:
                return
            last = self.drive.samples[-1]
            percent = self.drive.completion_percent
        print(f"referee: {percent:5.1f} %  {last.speed_mps:5.1f} m/s  cross-track error {last.cross_track_m:+.2f} m", flush=True)

    def wait_for_last_answers(self):
        """Commands travel on another connection than odometry: the last ones may still be under way."""
        limit = time.monotonic() + LAST_ANSWERS_S
        while self.answers.missed and time.monotonic() < limit and not rospy.is_shutdown():
            time.sleep(0.05)

    def finish(self):
        """Write the report; returns the exit status."""
        self.wait_for_last_answers()
        with self.lock:
            if self.drive is None or not self.drive.samples:
                rospy.logerr("referee: the drive ended before it began: no route or no odometry was heard")
                return 1
            wall_s = self.ended_at - self.started_at
            figures = self.drive.figures(self.ideal_duration_s)
        figures.update(wall_duration_s=wall_s, real_time_factor=figures["duration_s"] / max(wall_s, 1e-3),
                       ticks=self.answers.asked, missed_ticks=self.answers.missed)
        try:
            write_report(self.report_path, figures, self.drive)
        except ReportError as error:
            rospy.logfatal("referee: %s", error)
            return 1
        print(f"referee: {figures['status']}: {figures['route_completion_percent']:.1f} % of {figures['route_length_m']:.0f} m in "
              f"{figures['duration_s']:.1f} s ({figures['real_time_factor']:.1f} times real time), cross-track error "
              f"{figures['cross_track_rms_m']:.3f} m RMS, {figures['cross_track_max_m']:.3f} m at worst; "
              f"see {self.report_path}", flush=True)
        return 0 if figures["status"] == COMPLETED else 1

    def run(self):
        while not (rospy.is_shutdown() or self.ended.wait(1.0)):
            self.say_progress()
        return self.finish()


if __name__ == "__main__":
    sys.exit(Referee().run())
