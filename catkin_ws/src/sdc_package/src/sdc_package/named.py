"""Load what a parameter names as `module:name`.

Check one with: python3 -m sdc_package.named PARAMETER MODULE:NAME
"""

from __future__ import annotations

import importlib
import sys
from typing import Any

# A student's workspace has the package of a lab only after this command.
_COMMANDS_OF_LABS = {"sdc_mpc": "./workshop/start --lab mpc DIR"}


def load_named(parameter: str, named: str) -> Any:
    """Return what a parameter, with its value, names, such as `my_module:MyClass`.

    Raises:
        ValueError: it cannot be loaded; the message is one line with the fix
    """
    module_name, _, name = named.partition(":")
    try:
        return getattr(importlib.import_module(module_name), name)
    except (ImportError, SyntaxError, AttributeError, ValueError) as error:
        fix = f"the folder of {module_name}.py must be on the PYTHONPATH"
        missing_package = getattr(error, "name", None)
        if missing_package in _COMMANDS_OF_LABS:
            command = _COMMANDS_OF_LABS[missing_package]
            fix = f"{command} in the folder of the project adds it to the workspace DIR"
        raise ValueError(f"{parameter} cannot be loaded: {error}; {fix}") from error


if __name__ == "__main__":
    try:
        load_named("{} '{}'".format(*sys.argv[1:]), sys.argv[2])
    except ValueError as problem:
        sys.exit(f"drive: {problem}")
