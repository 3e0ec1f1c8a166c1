"""Fixtures for tests with real processes under a ROS master."""

import os

import pytest

HERE = os.path.dirname(os.path.abspath(__file__))


@pytest.fixture
def route():
    """Return a route that is driven in half a minute of simulated time."""
    return os.path.join(HERE, "routes", "fast_bends.csv")


@pytest.fixture
def bend(route, tmp_path):
    """Return a route along the first bend of that route, driven in ten seconds."""
    with open(route, encoding="utf-8") as file:
        rows = file.readlines()[40:125]
    path = tmp_path / "bend.csv"
    path.write_text("".join(rows))
    return path


@pytest.fixture
def environment(tmp_path):
    """Provide the environment of programs that belong to this test alone."""
    from sdc_common.processes import isolated_ros_environment  # needs ROS

    with isolated_ros_environment(tmp_path / "ros") as variables:
        yield variables


@pytest.fixture
def start(tmp_path):
    """Return a function that starts programs; end those that still run after the test."""
    from sdc_testing.program import programs  # needs ROS

    with programs(tmp_path) as begin:
        yield lambda command, environment, folder=tmp_path: begin(
            *command, environment=environment, cwd=folder
        )
