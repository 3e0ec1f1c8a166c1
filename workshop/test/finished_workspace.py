"""A student's workspace in which all steps are solved, built: what mistakes are made in, and what is to pass."""

import subprocess

from sdc_workshop.steps import load_steps
from sdc_workshop.workspace import make, solve


def solved(folder):
    """Make it in `folder`, a path that does not exist."""
    make(folder)
    for step in load_steps():
        solve(folder, step)
    build(folder)
    return folder


def build(folder):
    """As a student builds, in a new terminal."""
    done = subprocess.run(
        [
            "bash",
            "-c",
            "[ ! -f /opt/ros/noetic/setup.bash ] || . /opt/ros/noetic/setup.bash; catkin_make",
        ],
        cwd=folder,
        env={"HOME": str(folder), "PATH": "/usr/bin:/bin"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout
