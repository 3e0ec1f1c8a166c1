"""The stack of another workspace is found in that workspace, and errors are one line."""

import os
import xml.etree.ElementTree as ElementTree

import pytest

from sdc_sim import catkin_workspace
from sdc_sim.catkin_workspace import WorkspaceError, check_stack, workspace_environment

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
    environment = workspace_environment(workspace)
    return catkin_workspace.stack_launch(workspace, stack, environment, waypoints_path)


def test_environment_is_that_of_the_workspace_with_the_master_of_the_drive(workspace, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "/ours")
    monkeypatch.setenv("ROS_MASTER_URI", "http://here:11311")
    monkeypatch.setenv("MINE", "two\nlines=a=b")
    environment = workspace_environment(workspace)
    assert environment["ROS_PACKAGE_PATH"] == f"{workspace}/src"
    assert "PYTHONPATH" not in environment
    assert environment["ROS_MASTER_URI"] == "http://here:11311"
    assert environment["MINE"] == "two\nlines=a=b"


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
    assert text.startswith("<launch><node ")
    nodes = ElementTree.fromstring(text).findall("node")
    assert [node.get("output") for node in nodes] == ["screen", "screen"]
    found = [(node.get("pkg"), node.get("type"), node.get("name")) for node in nodes]
    pairs = ("planner.py", "planner"), ("controller", "controller")
    assert found == [("sdc_package", *pair) for pair in pairs]
    for node in nodes:
        assert node.find("param").attrib == {"name": "waypoints_path", "value": "/my <route>.csv"}


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
    assert str(error.value).endswith(
        "; give stack:=FILE.launch, stack:=PACKAGE/FILE.launch or "
        'stack:="PACKAGE/NODE PACKAGE/NODE"'
    )


@pytest.mark.parametrize(
    ("name", "reason"), [("", " has no devel/setup.bash; "), ("missing", " is not a folder; ")]
)
def test_workspace_that_is_not_built_is_refused(tmp_path, name, reason):
    folder = os.path.join(tmp_path, name)
    with pytest.raises(WorkspaceError) as error:
        check_stack(folder, "")
    assert f"workspace:={folder}: " in str(error.value)
    assert reason in str(error.value)
    assert (
        str(error.value).rstrip("/").endswith(f" build it first: catkin_make -C {tmp_path / name}")
    )


@pytest.mark.parametrize("setup", ["unset ROS_PACKAGE_PATH", "unset ROS_PACKAGE_PATH; exit 3"])
def test_setup_file_that_names_no_packages_is_refused(tmp_path, setup):
    (tmp_path / "setup.bash").write_text(setup + "\n")
    with pytest.raises(WorkspaceError, match="setup.bash sets no ROS_PACKAGE_PATH; build it$"):
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
    assert str(error.value).endswith(f"add workspace:={workspace}")
    os.rename(os.path.join(workspace, "devel"), os.path.join(workspace, "renamed"))
    with pytest.raises(WorkspaceError, match="add workspace:=FOLDER$"):
        check_stack("", stack)
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{workspace}/src")
    with open(stack, "w", encoding="utf-8") as file:
        file.write("<launch><!-- starts sdc_sim --></launch>")
    check_stack("", stack)
