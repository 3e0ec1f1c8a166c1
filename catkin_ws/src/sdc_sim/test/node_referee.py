#!/usr/bin/python3
"""Tests of the referee node with topics that only this test publishes."""

import json
import os
import shutil
import signal
import subprocess
import tempfile
import unittest

import rospkg
import rospy
import rostest
from carla_msgs.msg import CarlaCollisionEvent
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as DisplayedPath
from sdc_msgs.msg import BaseWaypoint, CarlaVehicleControl, Obstacle, ObstacleArray, Path
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger

from sdc_common.processes import wait_until
from sdc_common.ros.node import ENDED_PARAMETER
from sdc_common.ros.odometry import odometry_message
from sdc_testing import MessageListener

SCRIPTS = os.path.join(rospkg.RosPack().get_path("sdc_sim"), "scripts")
EGO = "/carla/ego_vehicle"
TICKS = 220
IMAGE = Image(height=48, width=64, encoding="bgra8", step=256, data=bytes(48 * 256))


def subscribers(publisher):
    """Return the names of the connected nodes."""
    return {connection[1] for connection in publisher.impl.get_stats_info()}


def stamp_of(tick):
    return rospy.Time(*divmod(50_000_000 * tick, 1_000_000_000))


class RefereeTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.mission = rospy.Publisher("/planner/mission_waypoints", Path, queue_size=1)
        cls.odometry = rospy.Publisher(EGO + "/odometry", Odometry, queue_size=1000)
        topic = EGO + "/vehicle_control_cmd"
        cls.command = rospy.Publisher(topic, CarlaVehicleControl, queue_size=1000)
        cls.collision = rospy.Publisher(EGO + "/collision", CarlaCollisionEvent, queue_size=10)
        cls.obstacles = rospy.Publisher(EGO + "/obstacles", ObstacleArray, queue_size=10)
        cls.publishers = cls.mission, cls.odometry, cls.command, cls.collision, cls.obstacles
        cls.image = rospy.Publisher(EGO + "/camera/rgb/front/image_color", Image, queue_size=10)

    def setUp(self):
        self.name = "/" + self.id().rsplit(".", 1)[1]
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = os.path.join(folder.name, "report")
        self.report_path = os.path.join(self.folder, "report.json")
        self.log_path = os.path.join(folder.name, "log")

    def start(self, **changes):
        """Start a referee and publish the route to it."""
        given = {"pictures": False, "snapshots": 0, "report": self.report_path, **changes}
        rospy.set_param(self.name, {**rospy.get_param("~good"), **given})
        script = os.path.join(SCRIPTS, "referee.py")
        command = [script, "__name:=" + self.name[1:], "__log:=/dev/null"]
        with open(self.log_path, "wb") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, start_new_session=True)
        self.addCleanup(self.end, process)
        self.publish_route()
        return process

    def publish_route(self):
        """Wait until the referee is connected, and publish the route."""
        for publisher in self.publishers:
            has = lambda one=publisher: self.name in subscribers(one)  # noqa: E731
            wait_until(has, 60.0, f"{self.name} on {publisher.resolved_name}")
        self.mission.publish(Path([BaseWaypoint(float(x), 0.0) for x in range(101)]))

    def end(self, process):
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()

    def log(self):
        with open(self.log_path, encoding="utf-8") as file:
            return file.read()

    def drive(self, first=1, last=TICKS, yaw=0.5):
        """Publish a drive along the x axis at 10 m/s, 0.3 m to the left.

        As with the 0.9.3 bridge, the twist is in the map frame and commands carry no stamps.
        """
        for tick in range(first, last):
            pose, speed = (min(0.5 * tick, 100.0), 0.3, yaw), 10.0 if tick < 200 else 0.0
            twist = (0.6 * speed, -0.8 * speed, 0.0)
            self.odometry.publish(odometry_message(stamp_of(tick), pose, twist))
            self.command.publish(CarlaVehicleControl(throttle=0.5))

    def logged_odometry(self):
        try:
            with open(os.path.join(self.folder, "report.events.jsonl"), "rb") as file:
                return file.read().count(b"odometry")
        except FileNotFoundError:
            return 0

    def drive_and_wait(self, first, last):
        self.drive(first, last)
        what = f"{last - 1} odometry messages in the file of events"
        wait_until(lambda: self.logged_odometry() >= last - 1, 30.0, what)

    def report(self, process, status):
        self.assertEqual(process.wait(timeout=60), status, self.log())
        self.assertNotIn("Traceback", self.log())
        with open(self.report_path, encoding="utf-8") as file:
            return json.load(file)

    def test_mission_is_published_as_a_path_of_nav_msgs(self):
        self.start()
        path = MessageListener("/planner/mission_path", DisplayedPath).wait_for(seconds=30.0)
        self.assertEqual(path.header.frame_id, "map")
        places = [(pose.pose.position.x, pose.pose.position.y) for pose in path.poses]
        self.assertEqual(places, [(float(x), 0.0) for x in range(101)])

    def test_another_stack_is_evaluated_by_the_topics_of_the_contract(self):
        pauses = []

        def pause(_request):
            pauses.append(os.path.exists(self.report_path))
            return True, "paused"

        service = rospy.Service("/sim/pause", Trigger, pause)
        self.addCleanup(service.shutdown)
        process = self.start()
        self.drive()
        report = self.report(process, 0)
        self.assertEqual(report["status"], "completed")
        self.assertEqual(pauses, [False], "one time, before the report exists")
        self.assertTrue(rospy.get_param(ENDED_PARAMETER), "no node warns of the stopped clock")
        self.assertAlmostEqual(report["cross_track_rms_m"], 0.3, places=6)
        self.assertAlmostEqual(report["speed_max_mps"], 10.0, places=6)
        self.assertAlmostEqual(report["heading_rms_rad"], 0.5, places=6)
        self.assertIn("planned_speed_mps", report["assumed_limits"])
        self.assertIn("/local_planner has no parameter planned_speed_mps", self.log())
        names = ["report.csv", "report.json", "report.parameters.json"]
        self.assertEqual(sorted(os.listdir(self.folder)), names)

    def test_removed_folder_does_not_end_the_drive(self):
        process = self.start()
        self.drive_and_wait(1, 100)
        shutil.rmtree(self.folder)
        with open(self.folder, "wb"):
            pass
        self.drive(100)
        self.assertEqual(process.wait(timeout=60), 1, self.log())
        self.assertIn(self.folder, self.log())
        self.assertIn("completed: 100.0 %", self.log())
        self.assertIn("not reported", self.log())
        self.assertNotIn("Traceback", self.log())

    def test_collision_ends_the_drive_and_the_page_has_a_snapshot(self):
        process = self.start(pictures=True, snapshots=2)
        self.obstacles.publish(ObstacleArray(obstacles=[Obstacle(id=103, kind="pedestrian")]))
        self.drive_and_wait(1, 120)
        wait_until(self.image.get_num_connections, 30.0, "the subscription to the camera")
        # A publisher notices the end of a subscription when it publishes.
        ends = lambda: self.image.publish(IMAGE) or not self.image.get_num_connections()  # noqa: E731
        wait_until(ends, 30.0, "the end of the subscription")
        self.collision.publish(CarlaCollisionEvent(other_actor_id=103))
        report = self.report(process, 1)
        self.assertEqual(report["status"], "collision")
        infractions = {name for name, count in report["infractions"].items() if count}
        self.assertEqual(infractions, {"collision_pedestrian"})
        self.assertAlmostEqual(report["driving_score"], 0.5 * report["route_completion_percent"])
        endings = "csv", "html", "json", "parameters.json", "png"
        self.assertEqual(sorted(os.listdir(self.folder)), [f"report.{one}" for one in endings])
        with open(os.path.join(self.folder, "report.html"), encoding="utf-8") as file:
            self.assertIn("data:image/jpeg", file.read())


if __name__ == "__main__":
    rospy.init_node("referee_test")
    rostest.rosrun("sdc_sim", "referee_test", RefereeTest)
