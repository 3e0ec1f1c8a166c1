#!/usr/bin/env python3
"""The referee on topics that this test alone publishes: another stack, a kill, a folder that vanishes, a full disk, a collision."""

import json
import math
import os
import resource
import shutil
import signal
import subprocess
import tempfile
import unittest
import xmlrpc.client

import rosgraph
import rospkg
import rospy
import rostest
from carla_msgs.msg import CarlaCollisionEvent
from nav_msgs.msg import Odometry
from sdc_msgs.msg import BaseWaypoint, CarlaVehicleControl, Obstacle, ObstacleArray, Path
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger

from sdc_common.testing.message_listener import wait_until

SCRIPTS = os.path.join(rospkg.RosPack().get_path("sdc_sim"), "scripts")
EGO = "/carla/ego_vehicle"
TICKS = 220
IMAGE = Image(height=48, width=64, encoding="bgra8", step=256, data=bytes(48 * 256))


def listeners(publisher):
    """Names of the nodes that are connected."""
    return {connection[1] for connection in publisher.impl.get_stats_info()}


class RefereeTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.mission = rospy.Publisher("/planner/mission_waypoints", Path, queue_size=1)
        cls.odometry = rospy.Publisher(EGO + "/odometry", Odometry, queue_size=1000)
        cls.command = rospy.Publisher(
            EGO + "/vehicle_control_cmd", CarlaVehicleControl, queue_size=1000
        )
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

    def start(self, prefix=(), at_most_bytes=None, **changes):
        """A referee that has heard the mission."""
        rospy.set_param(
            self.name,
            {
                **rospy.get_param("~good"),
                "pictures": False,
                "snapshots": 0,
                "drive_id": "here",
                "report": self.report_path,
                **changes,
            },
        )

        def limit():
            if at_most_bytes:
                resource.setrlimit(resource.RLIMIT_FSIZE, (at_most_bytes, at_most_bytes))

        with open(self.log_path, "wb") as log:
            process = subprocess.Popen(
                [
                    *prefix,
                    os.path.join(SCRIPTS, "referee.py"),
                    "__name:=" + self.name[1:],
                    "__log:=/dev/null",
                ],
                stdout=log,
                stderr=log,
                preexec_fn=limit,
                start_new_session=True,
            )
        self.addCleanup(self.end, process)
        self.meet()
        return process

    def meet(self):
        """Wait until the referee listens, and give it the mission."""
        for publisher in self.publishers:
            wait_until(
                lambda publisher=publisher: self.name in listeners(publisher),
                60.0,
                f"{self.name} on {publisher.resolved_name}",
            )
        self.mission.publish(Path([BaseWaypoint(float(x), 0.0) for x in range(101)]))

    def nobody_listens(self):
        """A publisher notices by writing that its listener has gone; what was said before is no news to a listener that is there."""
        for publisher, message in zip(
            self.publishers, (Path(), Odometry(), CarlaVehicleControl(), None, ObstacleArray())
        ):
            if message is not None and self.name in listeners(publisher):
                publisher.publish(message)
        return not any(self.name in listeners(publisher) for publisher in self.publishers[:3])

    def end(self, process):
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()

    def said(self):
        with open(self.log_path, encoding="utf-8") as file:
            return file.read()

    def drive(self, first=1, last=TICKS, yaw=0.5):
        """Along the x axis at 10 m/s, 0.3 m to the left, as the 0.9.3 bridge tells it: twist in the map, commands without stamps."""
        for tick in range(first, last):
            message = Odometry()
            message.header.stamp = rospy.Time(*divmod(50_000_000 * tick, 1_000_000_000))
            message.pose.pose.position.x = min(0.5 * tick, 100.0)
            message.pose.pose.position.y = 0.3
            message.pose.pose.orientation.z, message.pose.pose.orientation.w = (
                math.sin(0.5 * yaw),
                math.cos(0.5 * yaw),
            )
            speed = 10.0 if tick < 200 else 0.0
            message.twist.twist.linear.x, message.twist.twist.linear.y = 0.6 * speed, -0.8 * speed
            self.odometry.publish(message)
            self.command.publish(CarlaVehicleControl(throttle=0.5))

    def journal_lines(self):
        try:
            with open(os.path.join(self.folder, "report.journal"), "rb") as file:
                return file.read().count(b'"odometry"')
        except FileNotFoundError:
            return 0

    def drive_heard(self, first, last):
        self.drive(first, last)
        wait_until(
            lambda: self.journal_lines() >= last - 1,
            30.0,
            f"{last - 1} odometry messages in the journal",
        )

    def report(self, process, status):
        self.assertEqual(process.wait(timeout=60), status, self.said())
        self.assertNotIn("Traceback", self.said())
        with open(self.report_path, encoding="utf-8") as file:
            return json.load(file)

    def test_a_world_that_can_be_paused_stands_while_the_report_is_written(self):
        pauses = []

        def pause(_request):
            pauses.append(os.path.exists(self.report_path))
            return True, "paused"

        service = rospy.Service("/sim/pause", Trigger, pause)
        self.addCleanup(service.shutdown)
        process = self.start()
        self.drive()
        self.assertEqual(self.report(process, 0)["status"], "completed")
        self.assertEqual(pauses, [False], "once, before there was a report")

    def test_another_stack_is_scored_by_the_contracts_topics_alone(self):
        process = self.start()
        self.drive()
        report = self.report(process, 0)
        self.assertEqual(report["status"], "completed")
        self.assertAlmostEqual(report["cross_track_rms_m"], 0.3, places=6)
        self.assertAlmostEqual(report["speed_max_mps"], 10.0, places=6)
        self.assertAlmostEqual(report["heading_rms_rad"], 0.5, places=6)
        self.assertIn("planned_speed_mps", report["assumed_limits"])
        self.assertIn("/local_planner does not tell", self.said())
        self.assertEqual(sorted(os.listdir(self.folder)), ["report.csv", "report.json"])

    def test_a_killed_referee_goes_on_with_its_drive(self):
        process = self.start(prefix=("python3", "-m", "sdc_common.ros.supervisor"))
        self.drive_heard(1, 100)
        node = xmlrpc.client.ServerProxy(rosgraph.Master("/referee_test").lookupNode(self.name))
        os.kill(node.getPid("/referee_test")[2], signal.SIGKILL)
        wait_until(lambda: "was killed by" in self.said(), 30.0, "the word that it was killed")
        wait_until(self.nobody_listens, 30.0, "the end of the old connections")
        self.meet()
        self.drive_heard(100, 200)
        self.drive(200)
        report = self.report(process, 0)
        self.assertEqual((report["status"], report["referee_restarts"]), ("completed", 1))
        self.assertEqual(report["ticks"], 200)
        self.assertAlmostEqual(report["duration_s"], 9.95)
        self.assertEqual(report["unseen_s"], 0.0)
        self.assertIn("goes on with the drive after a restart", self.said())

    def test_a_folder_that_vanishes_ends_no_drive(self):
        process = self.start()
        self.drive_heard(1, 100)
        shutil.rmtree(self.folder)
        with open(self.folder, "wb"):
            pass
        self.drive(100)
        self.assertEqual(process.wait(timeout=60), 1, self.said())
        self.assertIn(self.folder, self.said())
        self.assertIn("completed: 100.0 %", self.said())
        self.assertIn("not reported", self.said())
        self.assertNotIn("Traceback", self.said())

    def test_a_full_disk_ends_no_drive_and_is_told(self):
        process = self.start(at_most_bytes=5000)
        self.drive()
        self.assertEqual(process.wait(timeout=60), 1, self.said())
        # The limit cuts a line in two, as a full disk does, or refuses the next one whole.
        self.assertRegex(
            self.said(),
            "report.journal: (No space left on device|File too large); the drive goes on",
        )
        self.assertIn("completed: 100.0 %", self.said())
        self.assertIn("not reported", self.said())
        self.assertNotIn("Traceback", self.said())

    def test_a_collision_ends_the_drive_and_the_camera_is_in_the_page(self):
        process = self.start(pictures=True, snapshots=2)
        self.obstacles.publish(ObstacleArray(obstacles=[Obstacle(id=103, kind="pedestrian")]))
        self.drive_heard(1, 120)
        wait_until(self.image.get_num_connections, 30.0, "the referee's wish for a picture")
        self.image.publish(IMAGE)
        wait_until(
            lambda: not self.image.get_num_connections(),
            30.0,
            "the end of that wish: a picture is heavy",
        )
        self.collision.publish(CarlaCollisionEvent(other_actor_id=103))
        report = self.report(process, 1)
        self.assertEqual(report["status"], "collision")
        self.assertEqual(
            {name for name, count in report["infractions"].items() if count},
            {"collision_pedestrian"},
        )
        self.assertAlmostEqual(report["driving_score"], 0.5 * report["route_completion_percent"])
        with open(os.path.join(self.folder, "report.html"), encoding="utf-8") as file:
            self.assertIn("data:image/jpeg", file.read())
        self.assertTrue(os.path.exists(os.path.join(self.folder, "report.png")))


if __name__ == "__main__":
    rospy.init_node("referee_test")
    rostest.rosrun("sdc_sim", "referee_test", RefereeTest)
