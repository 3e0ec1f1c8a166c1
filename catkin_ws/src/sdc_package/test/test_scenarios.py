"""Drive every packaged scenario in lockstep with real nodes: ./test scenarios."""

import os

import pytest

from sdc_common.ros.master_port import free_master_port
from sdc_sim.scenario.runner import CheckedDrive

FOLDER = os.path.join(
    os.path.dirname(os.path.abspath(__file__)), "..", "..", "sdc_sim", "scenarios"
)
NAMES = sorted(name[: -len(".yaml")] for name in os.listdir(FOLDER) if name.endswith(".yaml"))
TIMEOUT_S = 300.0


@pytest.fixture
def environment(tmp_path):
    return {
        **os.environ,
        "ROS_MASTER_URI": f"http://127.0.0.1:{free_master_port()}",
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(tmp_path / "ros"),
    }


@pytest.mark.parametrize("name", NAMES)
def test_drive_meets_the_limits_of_its_scenario(name, environment, tmp_path):
    drive = CheckedDrive(
        name, str(tmp_path / "report.json"), {"referee_options": "{pictures: false}"}
    )
    lines = drive.run(TIMEOUT_S, environment=environment)
    assert not lines, "\n".join(lines)
