#!/usr/bin/env python3
"""Reads launch files as roslaunch does, once for each list of arguments, and prints what they would start, as JSON on the last line: for
each file a list with one entry for each list of arguments, or the words of roslaunch about what it did not understand.
Usage: launch_probe.py '[["arg:=value"], ...]' FILE ..."""

import json
import sys

from roslaunch.config import ROSLaunchConfig
from roslaunch.core import RLException
from roslaunch.xmlloader import XmlLoader, XmlParseException


def read(path, arguments):
    config = ROSLaunchConfig()
    XmlLoader().load(path, config, argv=arguments, verbose=False)
    nodes = [
        {
            "name": node.name,
            "package": node.package,
            "type": node.type,
            "output": node.output,
            "namespace": node.namespace,
        }
        for node in config.nodes
    ]
    return {
        "nodes": nodes,
        "parameters": {name: parameter.value for name, parameter in config.params.items()},
    }


def main():
    found = []
    for path in sys.argv[2:]:
        try:
            found.append([read(path, [*case]) for case in json.loads(sys.argv[1])])
        except (XmlParseException, RLException, ValueError) as error:
            found.append(" ".join(str(error).split()))
    print(json.dumps(found))


if __name__ == "__main__":
    main()
