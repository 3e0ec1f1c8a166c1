"""Launch the stack of another catkin workspace in the environment of that workspace.

    python3 -m sdc_sim.catkin_workspace WORKSPACE STACK

checks the arguments `workspace` and `stack` of a drive. It prints one line and exits with 1 if they
cannot be driven.
"""

from __future__ import annotations

import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from pathlib import Path

import rospkg

_SETUP_FILES = ("devel/setup.bash", "install/setup.bash", "setup.bash")
# Set by the setup files of workspaces. They are unset, so that no other workspace is visible.
PATH_VARIABLES = (
    *("CMAKE_PREFIX_PATH", "LD_LIBRARY_PATH", "PKG_CONFIG_PATH", "PYTHONPATH"),
    *("ROSLISP_PACKAGE_DIRECTORIES", "ROS_PACKAGE_PATH"),
)
# A setup file may set these as well. The master of the drive stays the master of its stack.
_NETWORK_VARIABLES = ("ROS_MASTER_URI", "ROS_IP", "ROS_HOSTNAME")


class WorkspaceError(ValueError):
    """A workspace or stack that cannot be launched; the message is one line with the fix."""


def absolute_path(path: str) -> str:
    """Return a path as the caller of roslaunch means it, which starts nodes in another folder."""
    return os.path.join(os.environ.get("PWD", os.getcwd()), os.path.expanduser(path))


def workspace_environment(workspace: str) -> dict[str, str]:
    """Return the environment variables of programs of a built workspace.

    Raises:
        WorkspaceError: the workspace is not built
    """
    folder = Path(absolute_path(workspace))
    setup = next((folder / name for name in _SETUP_FILES if (folder / name).is_file()), None)
    if setup is None:
        reason = "has no devel/setup.bash" if folder.is_dir() else "is not a folder"
        raise WorkspaceError(
            f"workspace:={workspace}: {folder} {reason}; name the folder of a catkin workspace and "
            f"build it first: catkin_make -C {folder}"
        )
    own = {name: value for name, value in os.environ.items() if name not in PATH_VARIABLES}
    done = subprocess.run(
        ["bash", "-c", 'source "$0" >&2; exec env -0', str(setup)],
        env=own,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=False,
    )
    lines = os.fsdecode(done.stdout).split("\0")
    variables = dict(line.split("=", 1) for line in lines if line)
    if "ROS_PACKAGE_PATH" not in variables:
        raise WorkspaceError(f"workspace:={workspace}: {setup} sets no ROS_PACKAGE_PATH; build it")
    kept = {name: own[name] for name in _NETWORK_VARIABLES if name in own}
    return {**variables, **kept}


def stack_launch(
    workspace: str, stack: str, environment: Mapping[str, str], waypoints_path: str = ""
) -> tuple[tuple[str, ...], str]:
    """Return what roslaunch needs to launch a stack of a workspace.

    Args:
        workspace: folder of the workspace, for error messages
        stack: path of a launch file, PACKAGE/FILE.launch, or PACKAGE/NODE for each node, separated
            by spaces; empty: the stack.launch of sdc_package
        environment: that of the workspace
        waypoints_path: value of the parameter of this name of each node in a list of nodes

    Returns:
        the arguments of roslaunch and, if they contain "-", the launch file for its input

    Raises:
        WorkspaceError: the workspace has no such launch file or node
    """
    packages = rospkg.RosPack(environment["ROS_PACKAGE_PATH"].split(os.pathsep))
    if stack.endswith(".launch") and os.path.isfile(absolute_path(stack)):
        return (absolute_path(stack),), ""
    prefixes = filter(None, environment.get("CMAKE_PREFIX_PATH", "").split(os.pathsep))
    built = [Path(prefix) / "lib" for prefix in prefixes]
    launch = ElementTree.Element("launch")
    for word in stack.split() or ["sdc_package/stack.launch"]:
        package, _, name = word.partition("/")
        is_known = package in packages.list()
        source = [packages.get_path(package)] if is_known else []
        folders = [*source, *(folder / package for folder in built)]
        if not any(name in files for folder in folders for _, _, files in os.walk(folder)):
            raise WorkspaceError(
                f"workspace:={workspace}: "
                + (f"package {package} has no {name!r}" if is_known else f"no package {package!r}")
                + "; give stack:=FILE.launch, stack:=PACKAGE/FILE.launch or "
                'stack:="PACKAGE/NODE PACKAGE/NODE"'
            )
        if name.endswith(".launch"):
            return (package, name), ""
        attributes = {"pkg": package, "type": name, "name": name.split(".")[0]}
        node = ElementTree.SubElement(launch, "node", attributes, output="screen")
        ElementTree.SubElement(node, "param", name="waypoints_path", value=waypoints_path)
    return ("-",), ElementTree.tostring(launch, encoding="unicode")


def check_stack(workspace: str, stack: str) -> None:
    """Check the arguments `workspace` and `stack` of a drive.

    Raises:
        WorkspaceError: they cannot be driven, or would start nodes of another workspace
    """
    if workspace:
        stack_launch(workspace, stack, workspace_environment(workspace))
        return
    if stack:
        _check_that_nodes_are_found(Path(absolute_path(stack)))
    _check_all_launch()


def _check_all_launch() -> None:
    """Raise WorkspaceError if an overlay's package of the same name hides sdc_package."""
    try:
        folder = Path(rospkg.RosPack().get_path("sdc_package"))
    except rospkg.ResourceNotFound:
        return  # roslaunch names the missing package.
    launch = folder / "launch" / "all.launch"
    if not launch.exists() or "sdc_sim" not in launch.read_text(encoding="utf-8"):
        raise WorkspaceError(
            f"{folder}: this sdc_package hides the one whose all.launch starts the world; "
            "add workspace:=FOLDER, the workspace that it belongs to"
        )


def _check_that_nodes_are_found(stack: Path) -> None:
    """Raise WorkspaceError if the package of a launch file is not the one that roslaunch finds."""
    name = rospkg.get_package_name(str(stack))
    try:
        found = Path(rospkg.RosPack().get_path(name))
    except rospkg.ResourceNotFound:
        return
    if found.resolve() not in stack.resolve().parents:
        built = (str(path) for path in stack.parents if (path / "devel").is_dir())
        raise WorkspaceError(
            f"stack:={stack}: it would start the nodes of {found}, which has the same package name "
            f"{name}; add workspace:={next(built, 'FOLDER')}"
        )


def main() -> int:
    """Check the command line and return the exit status."""
    try:
        check_stack(*sys.argv[1:3])
    except WorkspaceError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
