"""What the arguments of all.launch make of the parameters of the nodes."""

import pathlib
import subprocess

import pytest
import yaml

SOURCES = pathlib.Path(__file__).resolve().parents[1] / "catkin_ws" / "src"

# Arguments, and the parameters that follow from them.
CONSEQUENCES = [
    (
        "",
        {
            "/sim/truth": True,
            "/sim/first_answer_s": 5.0,
            "/sim/wait_for_nodes": ["/referee", "/local_planner"],
            "/referee/finish_at_rest": True,
            "/referee/new_missions": False,
        },
    ),
    ("basic_control:=true", {"/sim/wait_for_nodes": ["/referee"]}),
    ("workspace:=/ws record:=true", {"/sim/wait_for_nodes": ["/referee", "/record"]}),
    (
        "map:=town goal:=[]",
        {
            "/local_planner/map": "town",
            "/local_planner/planned_speed_mps": 60.0,
            "/referee/new_missions": True,
        },
    ),
    ("localization:=true", {"/sim/truth": False, "/sim/gnss/period_s": 0.05}),
    ("localization:=true landmarks:=true", {"/sim/planar_lidar/period_s": 0.1}),
    (
        "localization:=true sensors:=standard truth:=true",
        {"/sim/truth": True, "/sim/gnss/period_s": 0.2},
    ),
    (
        "perception:=lane",
        {
            "/sim/truth": False,
            "/sim/gnss/period_s": 0.2,
            "/sim/planar_lidar/period_s": 0.0,
            "/sim/first_answer_s": 20.0,
            "/sim/wait_for_nodes": ["/referee"],
            "/referee/finish_at_rest": False,
        },
    ),
    (
        "perception:=objects map:=town goal:=[]",
        {
            "/local_planner/planned_speed_mps": 10.0,
            "/sim/truth": True,
            "/sim/first_answer_s": 20.0,
            "/sim/wait_for_nodes": ["/referee", "/local_planner"],
            "/referee/finish_at_rest": True,
        },
    ),
    (
        "perception:=objects map:=town goal:=[] localization:=true",
        {"/sim/truth": False, "/sim/gnss/period_s": 0.05, "/sim/first_answer_s": 20.0},
    ),
]
# Argument, node, file of its parameters, and other arguments that set some of them. The YAML of the
# argument wins over all else that sets the parameter.
OPTIONS = [
    ("referee_options", "/referee", "sdc_sim/config/referee.yaml", []),
    ("sim_options", "/sim", "sdc_sim/config/sim.yaml", ["truth:=true", "record:=true"]),
    ("planner_options", "/local_planner", "sdc_package/config/local_planner.yaml", []),
    (
        "planner_options",
        "/local_planner",
        "sdc_package/config/street_planner.yaml",
        ["map:=town", "goal:=[]"],
    ),
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


@pytest.mark.slow(3)
@pytest.mark.parametrize(
    ("argument", "node", "path", "others"), OPTIONS, ids=[row[2] for row in OPTIONS]
)
def test_each_option_reaches_the_node(argument, node, path, others):
    options = other(yaml.safe_load((SOURCES / path).read_text()))
    text = yaml.safe_dump(options, default_flow_style=True, width=100_000).strip()
    parameters = launched(*others, f"{argument}:={text}")
    assert leaves(node, options).items() <= parameters.items()


@pytest.mark.slow(3)
@pytest.mark.parametrize(
    ("arguments", "expected"), CONSEQUENCES, ids=[row[0] or "none" for row in CONSEQUENCES]
)
def test_arguments_set_what_follows_from_them(arguments, expected):
    parameters = launched(*arguments.split())
    assert {name: parameters[name] for name in expected} == expected


def launched(*arguments):
    """Return the parameters of a drive."""
    command = ["roslaunch", "--dump-params", "sdc_package", "all.launch"]
    command += ["headless:=true", *arguments]
    dumped = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return yaml.safe_load(dumped)


def leaves(name, value):
    """Return the parameters by the names that roslaunch gives them."""
    if not isinstance(value, dict):
        return {name: value}
    return {
        key: one for part in value for key, one in leaves(f"{name}/{part}", value[part]).items()
    }
