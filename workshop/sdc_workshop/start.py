"""./workshop/start DIR: makes a student's workspace."""

from __future__ import annotations

import sys
from pathlib import Path

from sdc_workshop.workspace import WorkspaceError, make

USAGE = """Usage: ./workshop/start DIR
Makes the workspace DIR of a student: the package sdc_package with the car's library, and nothing solved."""


def main(arguments) -> int:
    """Returns the exit status."""
    if arguments in (["--help"], ["-h"]):
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

    cd {folder}
    catkin_make
    source devel/setup.bash""")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
