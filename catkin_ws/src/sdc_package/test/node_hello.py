#!/usr/bin/env python3
"""hello.sh greets by rosrun and by roslaunch."""

import subprocess
import unittest

import rostest


class HelloTest(unittest.TestCase):
    def greeting_of(self, *command):
        return subprocess.run(
            command, check=True, stdout=subprocess.PIPE, text=True, timeout=60
        ).stdout

    def test_rosrun(self):
        self.assertIn("Hello!", self.greeting_of("rosrun", "sdc_package", "hello.sh"))

    def test_roslaunch(self):
        self.assertIn("Hello!", self.greeting_of("roslaunch", "sdc_package", "hello.launch"))


if __name__ == "__main__":
    rostest.rosrun("sdc_package", "hello", HelloTest)
