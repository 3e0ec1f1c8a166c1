#!/usr/bin/env python3
"""Referee: evaluates the drive along the route, prints its status, and writes the report."""

import contextlib
import json
import os
import sys
import threading
import time

import numpy as np
import rosgraph
import rospy
from nav_msgs.msg import Path
from std_msgs.msg import String
from std_srvs.srv import Trigger

from sdc_common.ros.node import ENDED_PARAMETER, parameter, refuse, watch_connections
from sdc_common.ros.odometry import true_odometry_topic
from sdc_common.ros.refusal import refusing
from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.evaluation.route_progress import COMPLETED
from sdc_sim.evaluation.rules import EvaluationRules
from sdc_sim.report.camera_snapshots import CameraSnapshots
from sdc_sim.report.console_progress import ConsoleProgress, closing_line
from sdc_sim.report.writer import (
    PARAMETERS,
    ReportError,
    companion,
    open_report,
    write_pages,
    write_report,
)
from sdc_sim.ros.bridge_versions import BRIDGE_VERSIONS
from sdc_sim.ros.connections import Connections
from sdc_sim.ros.evaluator_input import PATH_TOPIC, ROUTE_TOPIC, EvaluatorInput
from sdc_sim.ros.rviz_markers import route_path
from sdc_sim.ros.waypoint_messages import waypoint_rows
from sdc_sim.scenario.several_cars import names_of_cars

MISSION_PATH = "/planner/mission_path"
LAST_MESSAGES_S = 5.0
PAUSE_TIMEOUT_S = 0.5
NO_MISSION_S = 10.0
CHECK_MISSION_EVERY_S = 1.0


class Referee:
    def __init__(self):
        rospy.init_node("referee")
        self.report_path = os.path.expanduser(parameter("report"))
        self.pictures, self.cars = parameter("pictures"), parameter("cars")
        self.progress = ConsoleProgress(sys.stdout)
        role_name = parameter("role_name")
        bridges = BRIDGE_VERSIONS.values()
        image_topics = {f"/carla/{role_name}{bridge.front.image}" for bridge in bridges}
        self.snapshots = CameraSnapshots(
            sorted(image_topics),
            parameter("snapshots") if self.pictures else 0,
            self.add,
        )
        try:
            rules = EvaluationRules.read(parameter)
            self.events = open_report(self.report_path, self.on_write_failure)
        except ValueError as error:
            refuse(f"config/referee.yaml: {error}")
        except ReportError as error:
            refuse(error)

        self.lock = threading.Lock()
        self.ended = threading.Event()
        self.announce_end(False)
        self.mission_seen_s = self.mission_checked_s = time.monotonic()
        self.evaluator = Evaluator(rules, self.events)
        odometry_topic = true_odometry_topic("/carla/" + role_name)
        self.input = EvaluatorInput(self.evaluator, time.monotonic, role_name, odometry_topic)

        # The mission for nodes that do not know sdc_msgs.
        self.path_publisher = rospy.Publisher(MISSION_PATH, Path, queue_size=1, latch=True)
        self.rules_publisher = rospy.Publisher("/referee/rules", String, queue_size=1, latch=True)

        for topic, (message_class, handle) in self.input.topics.items():
            if topic == ROUTE_TOPIC:
                handle = self.on_route
            rospy.Subscriber(
                topic, message_class, self.on_message, callback_args=handle, tcp_nodelay=True
            )

    def on_message(self, message, handle):
        with self.lock:
            with refusing(message._connection_header["topic"], TypeError):
                handle(message)
            if self.evaluator.over:
                self.ended.set()

    def on_route(self, path):
        self.path_publisher.publish(route_path(np.array(waypoint_rows(path, "x", "y"))))
        if self.evaluator.drive is not None:
            self.input.route(path)
            return
        # The local planner's own limits, where it has them.
        own, rules = rospy.get_param("local_planner", {}), self.evaluator.rules
        planner = {name: own.get(name, value) for name, value in rules.planner.items()}
        assumed = [name for name in planner if name not in own]
        rules = rules._replace(planner=planner, assumed=assumed)
        self.evaluator.rules = rules
        self.input.route(path)
        if assumed:
            rospy.loginfo(
                "referee: /local_planner has no parameter %s; the ideal duration uses "
                "assumed_planner of config/referee.yaml",
                ", ".join(assumed),
            )
        self.rules_publisher.publish(json.dumps(rules._asdict()))
        path = companion(self.report_path, PARAMETERS)
        # A full disk must not end the drive.
        with contextlib.suppress(OSError), open(path, "w", encoding="utf-8") as file:
            json.dump(rospy.get_param("/"), file, indent=1, default=str)

    def on_write_failure(self, error):
        self.progress.print_line(
            f"referee: {error.filename}: {error.strerror}; the drive continues and its events "
            "are kept in memory"
        )

    def add(self, *event):
        with self.lock:
            self.evaluator.add(*event)

    def update_snapshots(self):
        with self.lock:
            if not self.evaluator.started:
                return
            progress = self.evaluator.drive.progress
            percent, now_s = progress.completion_percent, progress.samples[-1].time_s
        self.snapshots.update(percent, now_s, time.monotonic())

    def check_mission(self, now_s):
        """End the drive if for some time a planner has run, and no node that publishes a mission.

        Without a planner there is no mission to wait for, as in the first drive of the workshop.
        """
        if self.evaluator.drive is not None or now_s < self.mission_checked_s:
            return
        self.mission_checked_s = now_s + CHECK_MISSION_EVERY_S
        with contextlib.suppress(OSError, rosgraph.MasterException):
            graph = Connections()
            route, path = map(rospy.resolve_name, (ROUTE_TOPIC, PATH_TOPIC))
            publishers = graph.publishers.get(route, ())
            if not graph.publishers.get(path) or any(map(graph.is_reachable, publishers)):
                self.mission_seen_s = now_s
        if now_s - self.mission_seen_s > NO_MISSION_S:
            rospy.logerr("referee: no node publishes %s: is mission_planner running?", ROUTE_TOPIC)
            self.ended.set()

    def announce_end(self, ended):
        """Set whether the drive has ended; other cars of this world may drive on."""
        if self.cars == 1:
            with contextlib.suppress(OSError, rosgraph.MasterException):
                rospy.set_param(ENDED_PARAMETER, ended)

    def wait_for_last_messages(self):
        """Wait for the messages that answer the last odometry; they have other connections."""
        limit = time.monotonic() + LAST_MESSAGES_S
        while time.monotonic() < limit and not rospy.is_shutdown():
            with self.lock:
                if self.evaluator.drive is None or not self.evaluator.drive.awaits_messages:
                    return
            time.sleep(0.01)

    @staticmethod
    def pause_simulation():
        """Pause the simulator, which in lockstep keeps both cores busy; CARLA cannot."""
        with contextlib.suppress(rospy.ROSException, rospy.ServiceException):
            rospy.wait_for_service("/sim/pause", 0.1)
            rospy.ServiceProxy("/sim/pause", Trigger)()

    def wait_for_other_cars(self):
        """Wait until the referees of the other cars have ended."""
        left = [f"/{name}/referee" for name in names_of_cars(self.cars)[1:]]
        while left and not rospy.is_shutdown():
            time.sleep(0.1)
            with contextlib.suppress(OSError, rosgraph.MasterException):
                graph = Connections()
                left = [node for node in left if graph.is_reachable(node)]

    def finish(self):
        """Write the report; return the exit status."""
        self.wait_for_last_messages()
        self.snapshots.close()
        self.announce_end(True)
        if self.cars == 1 and not rospy.is_shutdown():
            # A simulator that does not respond must not delay the report.
            pausing = threading.Thread(target=self.pause_simulation, daemon=True)
            pausing.start()
            pausing.join(PAUSE_TIMEOUT_S)
        with self.lock:
            if not self.evaluator.started:
                topics = " and ".join(self.evaluator.missing_topics)
                rospy.logerr("referee: the drive did not start: no message on %s", topics)
                self.events.remove()
                return 1
            result = self.evaluator.result()
        line = closing_line(result.metrics, rospy.get_name().lstrip("/"))
        try:
            write_report(self.report_path, result)
            self.progress.print_line(f"{line}; see {self.report_path}")
            if self.pictures:
                write_pages(self.report_path, result)
        except ReportError as error:
            self.progress.print_line(line)
            rospy.logfatal("referee: %s", error)
            return 1
        with self.lock:
            self.events.remove()
        return 0 if result.metrics["status"] == COMPLETED else 1

    def run(self):
        watch_connections()
        while not (rospy.is_shutdown() or self.ended.wait(0.05)):
            now_s = time.monotonic()
            with self.lock:
                if self.cars:
                    self.progress.update(self.evaluator, now_s)
            self.update_snapshots()
            self.check_mission(now_s)
        status = self.finish()
        self.wait_for_other_cars()
        return status


if __name__ == "__main__":
    sys.exit(Referee().run())
