#!/usr/bin/env python3
"""Workspace stack: becomes the roslaunch of another workspace's stack, in its environment.

Usage: workspace_stack.py WORKSPACE STACK [ARG:=VALUE ...]
"""

import os
import sys

from sdc_sim.catkin_workspace import (
    WorkspaceError,
    absolute_path,
    stack_launch,
    workspace_environment,
)

STDIN = 0
# roslaunch ends this program after 15 s; its nodes must have ended by then.
TIMEOUTS = ("--sigint-timeout=8", "--sigterm-timeout=3")


def main():
    workspace, stack, *arguments = (word for word in sys.argv[1:] if not word.startswith("__"))
    arg_values = dict(argument.split(":=", 1) for argument in arguments)
    arg_values["waypoints_path"] = absolute_path(arg_values["waypoints_path"])
    try:
        environment = workspace_environment(workspace)
        words, xml = stack_launch(workspace, stack, environment, arg_values["waypoints_path"])
    except WorkspaceError as error:
        sys.exit(str(error))
    if xml:
        reader, writer = os.pipe()
        os.write(writer, xml.encode())
        os.close(writer)
        os.dup2(reader, STDIN)
    values = [f"{name}:={value}" for name, value in arg_values.items()]
    os.execvpe("roslaunch", ["roslaunch", *TIMEOUTS, *words, *values], environment)


if __name__ == "__main__":
    main()
