"""Run roslaunch without evaluating expressions in parameter files, on a master of this user.

Usage: python3 -m sdc_common.ros.safe_launch PACKAGE FILE.launch [ARG:=VALUE ...]

ROS evaluates `!radians pi/2` and `rad(pi/2)` in YAML files as Python, so that a parameter file can
run any code. Here such a line is an error.

roslaunch joins any master that responds. Where `drive_master` has found none, another program may
start one on the same port before roslaunch does. Then this launch ends with an error.
"""

from __future__ import annotations

import os
import signal
import sys

import roslaunch
import rosparam  # adds the expressions to YAML's safe loader
import yaml

from sdc_common.ros.drive_master import NEW_MASTER_VARIABLE


def refuse_expression(_loader: yaml.SafeLoader, node: yaml.ScalarNode) -> None:
    """Raise ConstructorError with the line of the expression."""
    what = f"the expression {node.value!r} is not evaluated; write the number"
    raise yaml.constructor.ConstructorError(None, None, what, node.start_mark)


def one_line(argument: str) -> str:
    """Return an argument without spaces and newlines at its ends.

    roslaunch ignores an argument NAME:=VALUE of several lines without a message.

    Raises:
        SystemExit: the value has several lines
    """
    argument = argument.strip()
    if "\n" in argument:
        name = argument.split(":=")[0]
        sys.exit(f"{name}: the value has several lines; write it in one line, as {{a: 1, b: 2}}")
    return argument


def main() -> None:
    """Disable expressions and run roslaunch."""
    # A caller that blocks Ctrl-C for itself, such as a worker of a sweep, interrupts the launch.
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    assert rosparam  # imported first, so that its constructors are replaced
    for tag in ("!radians", "!degrees"):
        yaml.SafeLoader.add_constructor(tag, refuse_expression)
    if os.environ.pop(NEW_MASTER_VARIABLE, ""):
        # roslaunch refuses a master with another id than its own, which it asks the master for.
        roslaunch.rlutil.get_or_generate_uuid = lambda *_: roslaunch.core.generate_run_id()
    roslaunch.main(["roslaunch", *map(one_line, sys.argv[1:])])


if __name__ == "__main__":
    main()
