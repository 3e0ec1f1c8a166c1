"""What a terminal that has sourced the workspace knows of the network."""

import os
import subprocess
from pathlib import Path

import pytest

SETUP = Path(__file__).resolve().parents[1] / "catkin_ws" / "devel" / "setup.bash"


@pytest.mark.parametrize(
    ("variables", "ros_ip"),
    [
        ({}, "127.0.0.1"),
        ({"ROS_MASTER_URI": "http://127.0.0.1:11500"}, "127.0.0.1"),
        ({"ROS_MASTER_URI": "http://10.0.0.1:11311"}, ""),
        ({"ROS_HOSTNAME": "lab3"}, ""),
        ({"ROS_IP": "10.0.0.2"}, "10.0.0.2"),
    ],
)
def test_terminal_listens_on_loopback_unless_the_user_has_set_an_address(variables, ros_ip):
    network = ("ROS_MASTER_URI", "ROS_IP", "ROS_HOSTNAME")
    environment = {name: value for name, value in os.environ.items() if name not in network}
    done = subprocess.run(
        ["bash", "-c", 'source "$0" && echo "$ROS_IP"', str(SETUP)],
        env={**environment, **variables},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == ros_ip
