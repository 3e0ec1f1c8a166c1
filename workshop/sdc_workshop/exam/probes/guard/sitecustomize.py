"""Refuse a student's program the solution in the project's folder, which no sandbox shows.

Python imports this module when it starts, where its folder is on the PYTHONPATH.
"""

import os
import sys

_SOURCES = os.path.realpath(
    os.path.join(os.path.dirname(__file__), *[".."] * 5, "catkin_ws", "src")
)
_SOLUTION = tuple(os.path.join(_SOURCES, name, "") for name in ("sdc_package", "labs"))
_GIVEN = os.path.join(_SOLUTION[0], "config", "")
_COMMANDS = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn")


def _refuse(event: str, arguments: tuple) -> None:
    path = ""
    if event == "open" and not isinstance(arguments[0], (int, type(None))):
        path = os.path.realpath(os.fsdecode(arguments[0]))
    elif event in _COMMANDS:
        path = next((folder for folder in _SOLUTION if folder in str(arguments)), "")
    if path.startswith(_SOLUTION) and not path.startswith(_GIVEN):
        raise PermissionError(f"{path} is a part of the solution")


sys.addaudithook(_refuse)
