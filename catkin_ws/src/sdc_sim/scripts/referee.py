#!/usr/bin/env python3
"""Referee: follows the drive along the route, tells how it goes, and writes the report when it ends."""

import contextlib
import json
import os
import sys
import threading
import time

import rospy
from carla_msgs.msg import (
    CarlaCollisionEvent,
    CarlaTrafficLightInfoList,
    CarlaTrafficLightStatusList,
)
from nav_msgs.msg import Odometry
from sdc_msgs.msg import CarlaVehicleControl, LocalPath, ObstacleArray, Path
from std_msgs.msg import String
from std_srvs.srv import Trigger

from sdc_common.ros.connection_watchdog import watch_connections
from sdc_common.ros.node import parameter, refuse
from sdc_sim.evaluation.evaluator import EvaluationRules, Evaluator
from sdc_sim.evaluation.route_progress import COMPLETED
from sdc_sim.report.camera_snapshots import CameraSnapshots
from sdc_sim.report.console_progress import ConsoleProgress, closing_line
from sdc_sim.report.writer import ReportError, open_report, write_pages, write_report
from sdc_sim.ros.evaluator_input import EvaluatorInput

LAST_ANSWERS_S = 1.0
PAUSE_PATIENCE_S = 0.5
# Somebody who commands is waited for so long, wall time, before the odometry is heard.
CONNECTING_S = 2.0


class Referee:
    def __init__(self):
        rospy.init_node("referee")
        self.report_path = os.path.expanduser(parameter("report"))
        self.pictures = parameter("pictures")
        self.progress = ConsoleProgress(sys.stdout)
        self.snapshots = CameraSnapshots(
            "/carla/ego_vehicle/camera/rgb/front/image_color", parameter("snapshots")
        )
        try:
            self.journal = open_report(self.report_path, parameter("drive_id"))
        except ReportError as error:
            refuse(error)

        self.lock = threading.Lock()
        self.ended = threading.Event()
        self.ended_at_s = None
        self.watch = Evaluator(EvaluationRules.read(parameter), self.journal)
        self.hearing = EvaluatorInput(self.watch)

        self.rules_publisher = rospy.Publisher("/referee/rules", String, queue_size=1, latch=True)

        rospy.Subscriber("/planner/mission_waypoints", Path, self.on_mission, queue_size=1)
        hears = {"callback": self.on_message, "tcp_nodelay": True}
        commands = rospy.Subscriber(
            "/carla/ego_vehicle/vehicle_control_cmd",
            CarlaVehicleControl,
            callback_args=self.hearing.command,
            **hears,
        )
        rospy.Subscriber(
            "/planner/local_waypoints", LocalPath, callback_args=self.hearing.local_path, **hears
        )
        rospy.Subscriber(
            "/carla/ego_vehicle/collision",
            CarlaCollisionEvent,
            callback_args=self.hearing.collision,
            **hears,
        )
        rospy.Subscriber(
            "/carla/ego_vehicle/obstacles",
            ObstacleArray,
            callback_args=self.hearing.obstacles,
            **hears,
        )
        rospy.Subscriber(
            "/carla/traffic_lights/info",
            CarlaTrafficLightInfoList,
            callback_args=self.hearing.light_info,
            **hears,
        )
        rospy.Subscriber(
            "/carla/traffic_lights/status",
            CarlaTrafficLightStatusList,
            callback_args=self.hearing.light_status,
            **hears,
        )
        # A world in lockstep starts when its odometry is heard here: by then its first answer must be heard, too.
        limit = time.monotonic() + CONNECTING_S
        while not (
            commands.get_num_connections() or rospy.is_shutdown() or time.monotonic() > limit
        ):
            time.sleep(0.01)
        rospy.Subscriber(
            "/carla/ego_vehicle/odometry", Odometry, self.on_odometry, tcp_nodelay=True
        )

    def on_mission(self, path):
        with self.lock:
            if self.watch.drive is not None:
                return
            assumed = self.look_up_planner()
            self.take(path, self.hearing.mission)
            if self.watch.drive is None:
                return
            if assumed:
                rospy.logwarn(
                    "referee: /local_planner does not tell %s; the ideal duration is reckoned with the figures of "
                    "config/referee.yaml",
                    ", ".join(assumed),
                )
            self.rules_publisher.publish(json.dumps(self.watch.rules._asdict()))

    def look_up_planner(self):
        """Judge by the planner's own limits; returns the names of those that had to be assumed."""
        usual = parameter("assumed_planner")
        assumed = [name for name in usual if not rospy.has_param("/local_planner/" + name)]
        told = {
            name: rospy.get_param("/local_planner/" + name) for name in usual if name not in assumed
        }
        self.watch.rules = self.watch.rules._replace(planner={**usual, **told}, assumed=assumed)
        return assumed

    def on_odometry(self, odometry):
        with self.lock:
            if not self.watch.over:
                self.ended_at_s = time.monotonic()
                self.watch.wall_clock(self.ended_at_s)
            self.take(odometry, self.hearing.odometry)

    def on_message(self, message, listen):
        with self.lock:
            self.take(message, listen)

    def take(self, message, listen):
        try:
            listen(message)
        except (TypeError, ValueError) as error:
            rospy.logwarn_throttle(
                1.0,
                f"referee: left out a message on {message._connection_header['topic']}: {error}",
            )
        if self.watch.over:
            self.ended.set()

    def wait_for_last_answers(self):
        """Commands travel on another connection than odometry: the last ones may still be under way."""
        limit = time.monotonic() + LAST_ANSWERS_S
        while self.watch.answers.awaited and time.monotonic() < limit and not rospy.is_shutdown():
            time.sleep(0.01)

    @staticmethod
    def pause_the_world():
        """The simulator in lockstep would go on beside the report, as fast as it can."""

        def ask():
            with contextlib.suppress(
                rospy.ROSException, rospy.ServiceException
            ):  # CARLA has no such service
                rospy.wait_for_service("/sim/pause", 0.1)
                rospy.ServiceProxy("/sim/pause", Trigger)()

        asking = threading.Thread(target=ask, daemon=True)
        asking.start()
        asking.join(PAUSE_PATIENCE_S)

    def finish(self):
        """Write the report; returns the exit status."""
        self.wait_for_last_answers()
        if not rospy.is_shutdown():
            self.pause_the_world()
        with self.lock:
            self.progress.tell_news(self.watch)
            if self.watch.drive is None or not self.watch.drive.samples:
                rospy.logerr(
                    "referee: the drive ended before it began: no route or no odometry was heard"
                )
                return 1
            result = self.watch.result(self.ended_at_s)
        try:
            write_report(self.report_path, result)
            self.progress.say(f"{closing_line(result.figures)}; see {self.report_path}")
            if self.pictures:
                write_pages(self.report_path, result, self.snapshots.taken)
        except ReportError as error:
            self.progress.say(closing_line(result.figures))
            rospy.logfatal("referee: %s", error)
            return 1
        self.journal.remove()
        return 0 if result.figures["status"] == COMPLETED else 1

    def run(self):
        watch_connections()
        while not (rospy.is_shutdown() or self.ended.wait(0.05)):
            with self.lock:
                self.progress.update(self.watch, time.monotonic())
                percent = self.watch.drive.completion_percent if self.watch.drive else 0.0
            self.snapshots.look(percent)
        self.snapshots.close()
        return self.finish()


if __name__ == "__main__":
    sys.exit(Referee().run())
