"""./workshop/start DIR: create a student's workspace."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Sequence

from sdc_workshop.steps import LABS, WORKSHOP
from sdc_workshop.workspace import WORLD_SETUP, WorkspaceError, find, make, package_of, update

DESCRIPTION = """Create a student's workspace DIR: the package sdc_package with its library and
empty TODOs. With --lab, the workspace gets the finished car and the package of the lab; a workspace
of the workshop keeps the car in it. With --update, the given files and lines of an existing
workspace become those of this version; what is written at the TODOs stays."""


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status."""
    parser = argparse.ArgumentParser(prog="./workshop/start", description=DESCRIPTION)
    parser.add_argument("folder", metavar="DIR", type=Path)
    parser.add_argument("--lab", choices=sorted(LABS), default=WORKSHOP, help="the lab")
    parser.add_argument("--update", action="store_true", help="update an existing workspace")
    options = parser.parse_args(arguments)
    folder = options.folder.absolute()
    try:
        if options.update:
            return _update(find(folder))
        make(folder, options.lab)
    except (WorkspaceError, OSError) as error:
        print(f"start: {error}", file=sys.stderr)
        return 1
    if options.lab:
        print(f"The package of the lab is src/{package_of(options.lab)}.")
    print(f"""Your workspace is {folder}. Open a new terminal and type:

    source {WORLD_SETUP}
    cd {folder}
    catkin_make
    source devel/setup.bash""")
    return 0


def _update(folder: Path) -> int:
    changed, copy = update(folder)
    for name in changed:
        print(f"updated: src/{name}")
    if changed:
        print(f"The old files are in {copy}. Now: catkin_make, and source devel/setup.bash")
    else:
        print(f"{folder} is up to date.")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
