"""Test that the tables in the READMEs agree with the code."""

import re
from pathlib import Path

import pytest
import yaml

PACKAGES = Path(__file__).resolve().parents[2]
NODES = ["world", "driverless", "qt_interface"]


def rows(package, heading):
    """Return the rows, without backticks, of the table whose first column is `heading`."""
    lines = (PACKAGES / package / "README.md").read_text().splitlines()
    begin = next(i for i, line in enumerate(lines) if line.startswith(f"| {heading} |"))
    table = []
    for line in lines[begin + 2 :]:
        if not line.startswith("|"):
            break
        table.append([cell.strip().replace("`", "") for cell in line.strip("|").split("|")])
    return table


@pytest.mark.parametrize("package", NODES)
def test_readme_lists_the_parameters_and_defaults_of_the_config_file(package):
    config = yaml.safe_load((PACKAGES / package / "config" / f"{package}.yaml").read_text())
    assert {name: yaml.safe_load(default) for name, default, *_ in rows(package, "parameter")} == {
        f"~{name}": value for name, value in config.items()
    }


@pytest.mark.parametrize("package", NODES)
def test_readme_lists_the_topics_of_the_node(package):
    code = (PACKAGES / package / "scripts" / f"{package}_node.py").read_text()
    in_code = {
        (topic, message, "out" if kind == "Publisher" else "in")
        for kind, topic, message in re.findall(
            r'rospy\.(Publisher|Subscriber)\(\s*"([^"]+)", (\w+)', code
        )
    }
    assert in_code, "the node has topics"
    assert {
        (topic, message.split("/")[1], way) for topic, message, way, _ in rows(package, "topic")
    } == in_code


def test_legend_lists_mouse_and_keys_as_the_readme_does():
    code = (PACKAGES / "qt_interface" / "src" / "qt_interface" / "legend.py").read_text()
    legend = re.findall(r'\("([^"]+)", "([^"]+)"\)', code.split("KEYS = (")[1].split("\n)")[0])
    table = [
        (
            key.split(",")[0],
            meaning.split(",")[0].replace("close the window and end the launch", "quit"),
        )
        for key, meaning in rows("qt_interface", "mouse and keys")
    ]
    assert legend == table


def test_readme_lists_the_arguments_of_the_launch_file():
    launch = (PACKAGES / "demo_launcher" / "launch" / "demo.launch").read_text()
    in_launch = dict(re.findall(r'<arg name="(\w+)" default="([^"]*)"', launch))
    assert {name: default for name, default, _ in rows("demo_launcher", "argument")} == in_launch


def test_readme_lists_the_fields_of_the_messages():
    in_files = {
        path.stem: [
            re.sub(r"\s+", " ", line.split("#")[0]).strip()
            for line in path.read_text().splitlines()
            if line.split("#")[0].strip()
        ]
        for path in (PACKAGES / "um_msgs" / "msg").glob("*.msg")
    }
    assert {name: fields.split(", ") for name, fields, _ in rows("um_msgs", "message")} == in_files
