"""The YAML of an argument such as referee_options wins over all else that sets the parameter."""

import pathlib
import subprocess

import pytest
import yaml

SOURCES = pathlib.Path(__file__).resolve().parents[1] / "catkin_ws" / "src"

# Argument, node, file of its parameters, and other arguments that set some of them.
OPTIONS = [
    ("referee_options", "/referee", "sdc_sim/config/referee.yaml", []),
    ("sim_options", "/sim", "sdc_sim/config/sim.yaml", ["truth:=true", "record:=true"]),
    ("planner_options", "/local_planner", "sdc_package/config/local_planner.yaml", []),
    (
        "perception_options",
        "/lane_detector",
        "labs/sdc_perception/config/lane_detector.yaml",
        ["perception:=lane"],
    ),
    (
        "perception_options",
        "/steering_network",
        "labs/sdc_perception/config/steering_network.yaml",
        ["perception:=imitation"],
    ),
]


def other(value):
    """Return a value of the same kind that differs."""
    if isinstance(value, dict):
        return {key: other(one) for key, one in value.items()}
    if isinstance(value, bool):
        return not value
    if isinstance(value, (int, float)):
        return value + 1
    return [*value, "other"] if isinstance(value, list) else value + "other"


@pytest.mark.parametrize(
    ("argument", "node", "path", "others"), OPTIONS, ids=[row[1][1:] for row in OPTIONS]
)
def test_each_option_reaches_the_node(argument, node, path, others):
    options = other(yaml.safe_load((SOURCES / path).read_text()))
    text = yaml.safe_dump(options, default_flow_style=True, width=100_000).strip()
    command = ["roslaunch", "--dump-params", "sdc_package", "all.launch", *others]
    command += ["headless:=true", f"{argument}:={text}"]
    dumped = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    parameters = yaml.safe_load(dumped)
    assert leaves(node, options).items() <= parameters.items()


def leaves(name, value):
    """Return the parameters by the names that roslaunch gives them."""
    if not isinstance(value, dict):
        return {name: value}
    return {
        key: one for part in value for key, one in leaves(f"{name}/{part}", value[part]).items()
    }
