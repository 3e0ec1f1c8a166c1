"""The library without ROS, and without what other systems lack."""

import subprocess
import sys
from pathlib import Path

SOURCES = Path(__file__).resolve().parents[1] / "catkin_ws" / "src"
# Modules of ROS and of Linux, and names of the standard library that Linux alone has.
_HIDE = """
import os, signal, socket, sys

sys.modules.update(dict.fromkeys(["fcntl", "resource", "grp", "pwd", "termios", "seccomp"]))
sys.modules.update(dict.fromkeys(["rospkg", "rospy", "rosgraph", "roslib", "genpy", "catkin"]))
for module, names in (
    (os, ["sched_getaffinity", "geteuid", "getuid", "fork", "pidfd_open", "fdatasync"]),
    (signal, ["SIGXCPU", "SIGSYS", "SIGKILL", "pthread_sigmask"]),
    (socket, ["SOCK_SEQPACKET", "AF_UNIX", "send_fds", "recv_fds"]),
):
    for name in names:
        if hasattr(module, name):
            delattr(module, name)
sys.path[:0] = sys.argv[1:]
from sdc_experiments.closed_loop import drive
from sdc_experiments import scenarios
from sdc_experiments.championship import attempt, race, rounds
from sdc_experiments.sweep import command, results

assert drive("slalom", longest_s=3.0)["route_completion_percent"] > 1.0
"""


def test_drive_needs_no_ros_and_nothing_that_other_systems_lack():
    packages = [*SOURCES.glob("*/src"), *SOURCES.glob("labs/*/src")]
    done = subprocess.run(
        [sys.executable, "-I", "-c", _HIDE, *map(str, packages)],
        capture_output=True,
        text=True,
        check=False,
        env={},
    )
    assert done.returncode == 0, done.stderr
