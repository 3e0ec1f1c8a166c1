#!/usr/bin/env python3
"""Load launch files as roslaunch does, once for each list of arguments; print JSON.

The JSON is the last line of the output. For each file it holds a list with one entry (nodes and
parameters) for each list of arguments, or the error message of roslaunch.
Usage: launch_probe.py '[["arg:=value"], ...]' FILE ...
"""

from __future__ import annotations

import json
import sys

from roslaunch.config import ROSLaunchConfig
from roslaunch.core import RLException
from roslaunch.xmlloader import XmlLoader, XmlParseException

_ATTRIBUTES = ("name", "package", "type", "output")


def read(path: str, arguments: list) -> dict:
    """Return the nodes and parameters of a launch file with these arguments."""
    config = ROSLaunchConfig()
    XmlLoader().load(path, config, argv=arguments, verbose=False)
    return {
        "nodes": [{name: getattr(node, name) for name in _ATTRIBUTES} for node in config.nodes],
        "parameters": {name: parameter.value for name, parameter in config.params.items()},
    }


def main() -> None:
    """Load all files and print what they hold."""
    found: list = []
    for path in sys.argv[2:]:
        try:
            found.append([read(path, [*case]) for case in json.loads(sys.argv[1])])
        except (XmlParseException, RLException, ValueError) as error:
            found.append(" ".join(str(error).split()))
    print(json.dumps(found))


if __name__ == "__main__":
    main()
