"""The READMEs' tables say what the code does."""

import os
import re

import pytest
import yaml

from sdc_package.steering.method import METHODS
from sdc_sim.evaluation.evaluator import EvaluationRules

SRC = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
NODES = {
    "sdc_package": ["camera", "local_planner", "mission_planner", "simple_controller"],
    "sdc_sim": ["referee", "sim"],
}
ALL = [(package, node) for package, nodes in NODES.items() for node in nodes]


def read(*parts):
    with open(os.path.join(SRC, *parts), encoding="utf-8") as file:
        return file.read()


def read_parameters(package, node):
    return set(re.findall(r'parameter\("([a-z_0-9]+)"\)', read(package, "scripts", node + ".py")))


@pytest.mark.parametrize(("package", "node"), ALL)
def test_every_topic_of_a_node_stands_in_its_row(package, node):
    code = read(package, "scripts", node + ".py").replace('EGO + "', '"/carla/ego_vehicle')
    used = set(re.findall(r'(?:[pP]ublisher|Subscriber)\(\s*"(/[a-z_/]+)"', code))
    row = next(
        line
        for line in read(package, "README.md").splitlines()
        if line.startswith(f"| `{node}.py`")
    )
    assert used
    assert used <= set(re.findall(r"`(/[a-z_/]+)`", row))


@pytest.mark.parametrize(("package", "node"), ALL)
def test_every_parameter_stands_in_the_readme(package, node):
    used = read_parameters(package, node)
    text = read(package, "README.md")
    assert [name for name in used if f"`{name}`" not in text] == []


@pytest.mark.parametrize(("package", "node"), ALL)
def test_every_line_of_the_configuration_reaches_the_node(package, node):
    path = os.path.join(package, "config", node + ".yaml")
    if not os.path.exists(os.path.join(SRC, path)):
        pytest.skip("set by its launch file alone")
    code = read(package, "scripts", node + ".py")
    for name in yaml.safe_load(read(path)):
        assert f'"{name}"' in code or name in METHODS or name in EvaluationRules._fields, (
            f"{path}: {name} is read by nobody"
        )


@pytest.mark.parametrize("package", NODES)
def test_every_line_of_the_configuration_has_its_unit(package):
    folder = os.path.join(SRC, package, "config")
    for name in sorted(os.listdir(folder)):
        if name.endswith(".yaml"):
            for number, line in enumerate(read(package, "config", name).splitlines(), start=1):
                opens_a_section = line.rstrip().endswith(":")
                assert "#" in line or not line.strip() or opens_a_section, (
                    f"{name}, line {number}: {line}"
                )


def test_every_argument_of_all_launch_stands_in_the_readme():
    names = re.findall(
        r'^  <arg name="([a-z_]+)"', read("sdc_package", "launch", "all.launch"), re.MULTILINE
    )
    text = read("..", "..", "README.md")
    assert [name for name in names if f"| `{name}` |" not in text] == []
