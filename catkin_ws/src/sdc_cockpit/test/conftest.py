"""Fixtures for tests with a real drive under a ROS master of its own."""

from pathlib import Path

import pytest

from sdc_common.processes import isolated_ros_environment
from sdc_testing.program import programs

ROOT = Path(__file__).resolve().parents[4]


@pytest.fixture
def start(tmp_path):
    """Return a function that starts a program and returns it with the address of its page."""
    with isolated_ros_environment(tmp_path / "ros") as variables, programs(tmp_path) as begin:

        def start(*command):
            program = begin(*command, environment=variables)
            return program, program.wait_for_match(r"cockpit: (http\S+)\s")

        yield start


@pytest.fixture
def drive(start):
    """Return a function that starts ./drive with a cockpit and returns the address of its page."""
    return lambda *arguments: start(ROOT / "drive", "headless:=true", "cockpit:=true", *arguments)


@pytest.fixture
def standing_cockpit(start):
    """Return a function that starts ./cockpit and returns the address of its page."""
    return lambda: start(str(ROOT / "cockpit"))[1]
