"""The stack of another workspace is found in that workspace, and errors are one line."""

import os
import xml.etree.ElementTree as ElementTree

import pytest

from sdc_common.ros.catkin_workspace import (
    WorkspaceError,
    check_stack,
    stack_launch,
    workspace_environment,
)

MANIFEST = "<package><name>{}</name></package>"
NODES = "sdc_package/planner.py sdc_package/controller"


@pytest.fixture
def workspace(tmp_path):
    """Create what a build leaves of a package that has the name of ours; return its folder."""
    folder = tmp_path / "their ws"
    package = folder / "src" / "sdc_package"
    for name in ("launch/all.launch", "launch/stack.launch", "scripts/planner.py"):
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text("<launch/>")
    (package / "package.xml").write_text(MANIFEST.format("sdc_package"))
    built = folder / "devel" / "lib" / "sdc_package"
    built.mkdir(parents=True)
    (built / "controller").write_text("")
    (folder / "devel" / "setup.bash").write_text(
        f"export ROS_PACKAGE_PATH='{folder}/src' CMAKE_PREFIX_PATH='{folder}/devel'\n"
        "export ROS_MASTER_URI=http://elsewhere:11311\necho sourced\n"
    )
    return str(folder)


def launched(workspace, stack, waypoints_path=""):
    return stack_launch(workspace, stack, workspace_environment(workspace), waypoints_path)


def test_environment_is_that_of_the_workspace_with_the_master_of_the_drive(workspace, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "/ours")
    monkeypatch.setenv("ROS_MASTER_URI", "http://here:11311")
    monkeypatch.setenv("MINE", "two\nlines")
    environment = workspace_environment(workspace)
    assert environment["ROS_PACKAGE_PATH"] == f"{workspace}/src"
    assert "PYTHONPATH" not in environment
    assert environment["ROS_MASTER_URI"] == "http://here:11311"
    assert environment["MINE"] == "two\nlines"


def test_relative_workspace_starts_at_the_folder_of_the_caller(workspace, monkeypatch):
    monkeypatch.setenv("PWD", os.path.dirname(workspace))
    assert "ROS_PACKAGE_PATH" in workspace_environment("their ws")


@pytest.mark.parametrize(
    ("stack", "arguments"),
    [
        ("", ("sdc_package", "stack.launch")),
        ("sdc_package/all.launch", ("sdc_package", "all.launch")),
        ("{}/src/sdc_package/launch/all.launch", ("{}/src/sdc_package/launch/all.launch",)),
    ],
)
def test_launch_file_of_a_workspace_is_found(workspace, stack, arguments):
    found = launched(workspace, stack.format(workspace))
    assert found == (tuple(word.format(workspace) for word in arguments), "")


def test_list_of_nodes_becomes_a_launch_file(workspace):
    arguments, text = launched(workspace, NODES, "/my <route>.csv")
    assert arguments == ("-",)
    nodes = ElementTree.fromstring(text).findall("node")
    assert [(node.get("pkg"), node.get("type"), node.get("name")) for node in nodes] == [
        ("sdc_package", "planner.py", "planner"),
        ("sdc_package", "controller", "controller"),
    ]
    assert nodes[0].find("param").get("value") == "/my <route>.csv"


@pytest.mark.parametrize(
    ("stack", "parts"),
    [
        ("sdc_package/missing.launch", ["package sdc_package has no 'missing.launch'", "stack:="]),
        ("sdc_package/plan.py", ["package sdc_package has no 'plan.py'"]),
        ("sdc_package/planner.py other/node", ["no package 'other'"]),
        ("planner.py", ["no package 'planner.py'", "PACKAGE/NODE"]),
        ("/nowhere/all.launch", ["no package ''"]),
    ],
)
def test_stack_that_is_not_there_is_named_in_one_line(workspace, stack, parts):
    with pytest.raises(WorkspaceError) as error:
        check_stack(workspace, stack)
    assert [part for part in [workspace, *parts] if part not in str(error.value)] == []
    assert "\n" not in str(error.value)


def test_workspace_that_is_not_built_is_refused(tmp_path):
    with pytest.raises(WorkspaceError, match=r"has no devel/setup\.bash.*catkin_make -C"):
        check_stack(str(tmp_path), "")
    with pytest.raises(WorkspaceError, match="is not a folder"):
        check_stack(str(tmp_path / "missing"), "")
    (tmp_path / "setup.bash").write_text("unset ROS_PACKAGE_PATH\n")
    with pytest.raises(WorkspaceError, match="sets no ROS_PACKAGE_PATH"):
        check_stack(str(tmp_path), "")


def test_stack_that_would_start_nodes_of_another_workspace_is_refused(workspace, monkeypatch):
    stack = f"{workspace}/src/sdc_package/launch/all.launch"
    ours = os.path.join(os.path.dirname(workspace), "ours")
    os.makedirs(ours)
    with open(os.path.join(ours, "package.xml"), "w", encoding="utf-8") as file:
        file.write(MANIFEST.format("sdc_package"))
    monkeypatch.setenv("ROS_PACKAGE_PATH", ours)
    with pytest.raises(WorkspaceError) as error:
        check_stack("", stack)
    assert f"nodes of {ours}" in str(error.value)
    assert f"add workspace:={workspace}" in str(error.value)
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{workspace}/src")
    check_stack("", stack)
