#!/usr/bin/python3
"""An invalid parameter or file ends the sim with one line that names it; unusual routes work."""

import math
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import rospkg
import rospy
import rostest
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image

from sdc_testing import MessageListener

SIM = os.path.join(rospkg.RosPack().get_path("sdc_sim"), "scripts", "sim.py")
CAMERA = os.path.join(rospkg.RosPack().get_path("sdc_sim"), "scripts", "front_camera.py")
# Starts a sim for each node's name that it reads: the imports take most of the time of a start.
PREPARED = f"""
import os, signal, sys
import jsonschema, ruamel.yaml  # what reads the files
import rospy
from sdc_testing import load_script

script = load_script({SIM!r})
for name in map(str.strip, sys.stdin):
    if os.fork() == 0:
        sys.argv = [{SIM!r}, "__name:=" + name]
        rospy.names.reload_mappings(sys.argv)
        signal.alarm(60)  # ends a sim that refuses nothing
        script.Sim().run()
        break
    print("exit status", os.WEXITSTATUS(os.wait()[1]), flush=True)
"""
OBSTACLE_ON_START = "frame: route\nobstacles:\n  - {kind: car, at: [1.0, 0.0]}\n"


class RefusalsTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def file(self, name, text):
        path = os.path.join(self.folder.name, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def run_program(self, *command):
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.addCleanup(process.kill)
        return process

    def start(self, name, **changes):
        self.set_parameters(name, changes)
        return self.run_program("/usr/bin/env", "python3", SIM, "__name:=" + name)

    def set_parameters(self, name, changes):
        rospy.set_param("/" + name, {**rospy.get_param("~good"), **changes})

    def test_error_names_what_is_wrong(self):
        with open(
            os.path.join(rospy.get_param("~good/vehicles_folder"), "tesla_model3.yaml"),
            encoding="utf-8",
        ) as file:
            tesla = file.read()
        self.file("negative.yaml", tesla.replace("mass_kg: 1845.0", "mass_kg: -5.0"))
        typing_error = self.file(
            "typo.scenario", "frame: map\nobstacles:\n  - kind: pedestrain\n    at: [5, 5]\n"
        )
        rows = [
            (
                "scenario",
                {"obstacles_path": typing_error},
                ["typo.scenario, line 3", "did you mean 'pedestrian'"],
            ),
            (
                "blocked",
                {"obstacles_path": self.file("b.yaml", OBSTACLE_ON_START)},
                ["the car at (1.0, 0.0)"],
            ),
            (
                "negative",
                {"vehicles_folder": self.folder.name, "vehicle": "negative"},
                ["negative.yaml", "mass_kg"],
            ),
            ("route", {"waypoints_path": self.file("r.csv", "1,2\n")}, ["r.csv", "at least 2"]),
            ("misspelt", {"frictoin": 0.5}, ["frictoin", "did you mean 'friction'"]),
            ("friction", {"friction": -1.0}, ["friction", "config/sim.yaml"]),
            ("latency", {"sensor_latency_s": -0.1}, ["sensor_latency_s", "config/sim.yaml"]),
            ("daylight", {"daylight": 2.0}, ["daylight", "from 0 to 1", "config/sim.yaml"]),
            (
                "start",
                {"start": {"along_m": 1e6, "left_m": 0.0, "turned_rad": 0.0}},
                ["along_m", "config/sim.yaml"],
            ),
            ("bridge", {"bridge": "newer"}, ["bridge is 'newer'", "old, new"]),
            ("ackermann", {"ackermann": {"kp": 1.0}}, ["kp", "config/sim.yaml"]),
        ]
        prepared = self.run_program(sys.executable, "-c", PREPARED)
        for number, (name, changes, words) in enumerate(rows):
            with self.subTest(name):
                self.set_parameters("bad_" + name, changes)
                if number:
                    print("bad_" + name, file=prepared.stdin, flush=True)
                    output = line = ""
                    for line in iter(prepared.stdout.readline, ""):
                        if line.startswith("exit status"):
                            break
                        output += line
                    self.assertEqual(line, "exit status 1\n", output)
                else:
                    sim = self.run_program(sys.executable, SIM, "__name:=bad_" + name)
                    output, _ = sim.communicate(timeout=60)
                    self.assertEqual(sim.returncode, 1, output)
                self.assertNotIn("Traceback", output)
                for word in words:
                    self.assertIn(word, output)

    def start_on(self, name, waypoints_path, camera=True, **changes):
        """Start the sim on this route; return the mean brightness 0..255 of its first picture."""
        odometry = MessageListener("/carla/" + name + "/odometry", Odometry)
        image = MessageListener("/carla/" + name + "/camera/rgb/front/image_color", Image)
        changes.update(waypoints_path=waypoints_path, role_name=name, camera=camera)
        if camera:
            changes["picture_feed"] = os.path.join(self.folder.name, name)
            rospy.set_param("/front_camera/picture_feed", changes["picture_feed"])
            pictures = subprocess.Popen([sys.executable, CAMERA])
            self.addCleanup(pictures.wait)
        sim = self.start(name, **changes)
        try:
            picture = image.wait_for(seconds=60.0) if camera else None
            first = odometry.wait_for(seconds=60.0)
            self.assertTrue(
                all(map(math.isfinite, (first.pose.pose.position.x, first.pose.pose.orientation.w)))
            )
        finally:
            sim.terminate()
            output, _ = sim.communicate(timeout=60)
        self.assertNotIn("Traceback", output)
        self.output = output
        return camera and np.frombuffer(picture.data, np.uint8).reshape(-1, 4)[:, :3].mean()

    def test_route_of_two_points_has_pictures(self):
        brightness = self.start_on("two_points", self.file("two.csv", "0,0\n30,10\n"))
        self.assertGreater(brightness, 30.0)

    def test_bend_that_the_car_cannot_take_is_named(self):
        turn = [math.radians(angle) for angle in range(-90, 91, 30)]
        rows = "".join(f"{20 + 2 * math.cos(a):.3f},{-2 * math.sin(a) - 2:.3f}\n" for a in turn)
        self.start_on("bend", self.file("bend.csv", "0,0\n10,0\n" + rows + "0,-4\n"), camera=False)
        self.assertRegex(self.output, r"bend.csv: the bend at .* has a radius of [12]\.\d m")

    def test_route_of_100000_points_works(self):
        rows = "".join(f"{0.5 * n:.3f},{300.0 * math.sin(n / 900.0):.3f}\n" for n in range(100_000))
        self.start_on("long_route", self.file("long.csv", rows))


if __name__ == "__main__":
    rospy.init_node("refusals_test")
    rostest.rosrun("sdc_sim", "refusals_test", RefusalsTest)
