import subprocess
import sys

import pytest

from sdc_common.processes import isolated_ros_environment, processes_with
from sdc_testing.program import Program

SLEEP = [sys.executable, "-c", "import time; print('ready'); time.sleep(600)"]


@pytest.fixture
def program(tmp_path):
    programs = []

    def start(command, environment):
        programs.append(Program(command, environment, tmp_path, tmp_path / "log"))
        return programs[-1]

    yield start
    for running in programs:
        running.process.kill()
        running.process.wait()


def test_process_is_found_by_its_environment(program, tmp_path):
    with isolated_ros_environment(tmp_path) as environment:
        uri = environment["ROS_MASTER_URI"]
        running = program(SLEEP, environment)
        running.wait_for_output("ready")
        assert [process.pid for process in processes_with("ROS_MASTER_URI", uri)] == [
            running.process.pid
        ]
        assert running.pid_of("python") == running.process.pid
        assert running.interrupt() != 0


def test_process_in_another_network_is_left_out(program, tmp_path):
    if subprocess.run(["unshare", "--net", "true"], capture_output=True).returncode:
        pytest.skip("no network namespace can be made here")
    with isolated_ros_environment(tmp_path) as environment:
        running = program(["unshare", "--net", *SLEEP], environment)
        running.wait_for_output("ready")
        assert processes_with("ROS_MASTER_URI", environment["ROS_MASTER_URI"]) == []


def test_process_that_is_left_behind_is_killed_and_reported(program, tmp_path):
    with pytest.raises(AssertionError, match="left behind"):  # noqa: SIM117
        with isolated_ros_environment(tmp_path, timeout_s=0.2) as environment:
            running = program(SLEEP, environment)
            running.wait_for_output("ready")
    assert running.wait_for_end(10.0) == -9
