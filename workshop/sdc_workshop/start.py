"""./workshop/start DIR: create a student's workspace."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Sequence

from sdc_experiments.commands import WordError, parse
from sdc_workshop.workspace import WORLD_SETUP, WorkspaceError, find, make, package_of, update


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status."""
    try:
        options = parse("workshop/start", arguments)
        folder = Path(options.dir).absolute()
        if options.update:
            return _update(find(folder))
        make(folder, options.lab)
    except (WordError, WorkspaceError, OSError) as error:
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
