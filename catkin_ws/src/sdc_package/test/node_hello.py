#!/usr/bin/python3
"""hello.sh prints a greeting with rosrun and with roslaunch."""

import subprocess
import unittest

import rostest


class HelloTest(unittest.TestCase):
    def output_of(self, *command):
        return subprocess.run(
            command, check=True, stdout=subprocess.PIPE, text=True, timeout=60
        ).stdout

    def test_rosrun_prints_the_greeting(self):
        self.assertIn("Hello!", self.output_of("rosrun", "sdc_package", "hello.sh"))

    def test_roslaunch_prints_the_greeting(self):
        self.assertIn("Hello!", self.output_of("roslaunch", "sdc_package", "hello.launch"))


if __name__ == "__main__":
    rostest.rosrun("sdc_package", "hello", HelloTest)
