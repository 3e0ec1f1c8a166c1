"""Fixtures for tests with real processes under a ROS master of their own."""

import os

import pytest

from sdc_common.testing.processes import Program, isolated_ros_environment

HERE = os.path.dirname(os.path.abspath(__file__))


@pytest.fixture
def route():
    """Return a route that is driven in half a minute of simulated time."""
    return os.path.join(HERE, "routes", "fast_bends.csv")


@pytest.fixture
def environment(tmp_path):
    """Provide the environment of programs that belong to this test alone."""
    with isolated_ros_environment(tmp_path / "ros") as variables:
        yield variables


@pytest.fixture
def other_environment(tmp_path):
    """Provide a second environment, as for a second drive on this machine."""
    with isolated_ros_environment(tmp_path / "other_ros") as variables:
        yield variables


@pytest.fixture
def start(tmp_path):
    """Return a function that starts programs; end those that still run after the test."""
    programs = []

    def begin(command, environment, folder=tmp_path):
        programs.append(Program(command, environment, folder, tmp_path / f"log{len(programs)}"))
        return programs[-1]

    yield begin
    for program in programs:
        if program.process.poll() is None:
            program.interrupt()
