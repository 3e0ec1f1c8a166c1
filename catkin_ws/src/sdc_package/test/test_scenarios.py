"""Every packaged scenario is driven in lockstep by real nodes, and keeps its limits: ./test scenarios"""

import os
import socket

import pytest

from sdc_sim.scenario.checked_drive import CheckedDrive

FOLDER = os.path.join(
    os.path.dirname(os.path.abspath(__file__)), "..", "..", "sdc_sim", "scenarios"
)
NAMES = sorted(name[: -len(".yaml")] for name in os.listdir(FOLDER) if name.endswith(".yaml"))
WALL_LIMIT_S = 300.0


@pytest.fixture
def environment(tmp_path):
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    return {
        **os.environ,
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(tmp_path / "ros"),
    }


@pytest.mark.parametrize("name", NAMES)
def test_scenario(name, environment, tmp_path):
    drive = CheckedDrive(
        name, str(tmp_path / "report.json"), {"referee_options": "{pictures: false}"}
    )
    fell_short = drive.run(WALL_LIMIT_S, environment=environment)
    assert not fell_short, "\n".join(fell_short)
