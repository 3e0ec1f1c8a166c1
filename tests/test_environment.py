"""What a sourced terminal knows of the network, and which of CARLA's packages the build uses."""

import os
from pathlib import Path

import pytest

from sdc_testing.program import run

ROOT = Path(__file__).resolve().parents[1]
SETUP = ROOT / "catkin_ws" / "devel" / "setup.bash"


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
    command = "bash", "-c", 'source "$0" && echo "$ROS_IP"', SETUP
    assert run(*command, environment={**environment, **variables}).stdout.strip() == ros_ip


def found(prefix):
    """Return what the build leaves out while packages are installed below this folder."""
    command = "bash", "-ec", ". docker/environment; NOETIC=; installed_message_packages"
    environment = {**os.environ, "CMAKE_PREFIX_PATH": str(prefix)}
    return run(*command, folder=ROOT, environment=environment).stdout


def test_build_uses_an_installed_package_instead_of_the_own_one(tmp_path):
    before = found(tmp_path)
    config = tmp_path / "share" / "carla_msgs" / "cmake" / "carla_msgsConfig.cmake"
    config.parent.mkdir(parents=True)
    config.touch()
    assert "carla_msgs;" in found(tmp_path)
    assert found(tmp_path).replace("carla_msgs;", "") == before.replace("carla_msgs;", "")


def test_own_packages_count_as_not_installed():
    devel = ROOT / "catkin_ws" / "devel"
    assert (devel / "share" / "carla_msgs" / "cmake" / "carla_msgsConfig.cmake").exists()
    assert found(devel) == found(ROOT)
