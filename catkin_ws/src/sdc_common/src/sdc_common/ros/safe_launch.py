"""roslaunch whose parameters run no code: python3 -m sdc_common.ros.safe_launch PACKAGE FILE.launch [ARG:=VALUE ...]

ROS lets a parameter be written as an expression, `!radians pi/2` or `rad(pi/2)`, and evaluates it as Python: a YAML file could do
anything. Here such a line is refused like any other mistake.
"""

from __future__ import annotations

import sys

import roslaunch
import rosparam  # adds the expressions to YAML's safe loader, from which they are taken away again
import yaml

EXPRESSIONS = ("!radians", "!degrees")


def refuse(_loader, node):
    """Raises ConstructorError with the line of the expression."""
    raise yaml.constructor.ConstructorError(
        None,
        None,
        f"the expression {node.value!r} is not evaluated; write the number",
        node.start_mark,
    )


def main() -> None:
    """Refuse expressions from now on, and run roslaunch."""
    assert rosparam
    for tag in EXPRESSIONS:
        yaml.SafeLoader.add_constructor(tag, refuse)
    roslaunch.main(["roslaunch", *sys.argv[1:]])


if __name__ == "__main__":
    main()
