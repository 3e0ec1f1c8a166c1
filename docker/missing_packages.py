"""Print the rows of a list of packages that this Python does not have.

missing_packages.py LIST [EXTRA]: EXTRA is a name in [project.optional-dependencies] of
pyproject.toml, and rows of other packages are left out.
"""

import ast
import re
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path


def is_installed(name, wanted):
    try:
        return version(name) == wanted
    except PackageNotFoundError:
        return False


def main(path, extra=""):
    rows = re.findall(r"^(([\w.-]+)==(\S+)(?:.*\\\n)*.*\n)", Path(path).read_text(), re.MULTILINE)
    project = Path(__file__).resolve().parents[1] / "pyproject.toml"
    # Python 3.8 has no tomllib; an extra is one line.
    names = extra and ast.literal_eval(
        re.search(rf"^{extra} = (\[.*\])", project.read_text(), re.MULTILINE)[1]
    )
    for row, name, wanted in rows:
        if (not extra or name in names) and not is_installed(name, wanted):
            print(row, end="")


if __name__ == "__main__":
    main(*sys.argv[1:])
