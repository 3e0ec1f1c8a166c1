"""./workshop/start DIR: create a student's workspace."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Sequence

from sdc_workshop.workspace import WORLD_SETUP, WorkspaceError, make

USAGE = """Usage: ./workshop/start DIR
Create a student's workspace DIR: the package sdc_package with its library and empty TODOs."""


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status."""
    if list(arguments) in (["--help"], ["-h"]):
        print(USAGE)
        return 0
    if len(arguments) != 1 or arguments[0].startswith("-"):
        print(USAGE, file=sys.stderr)
        return 2
    folder = Path(arguments[0]).absolute()
    try:
        make(folder)
    except (WorkspaceError, OSError) as error:
        print(f"start: {error}", file=sys.stderr)
        return 1
    print(f"""Your workspace is {folder}. Open a new terminal and type:

    source {WORLD_SETUP}
    cd {folder}
    catkin_make
    source devel/setup.bash""")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
