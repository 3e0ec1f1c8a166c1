"""Copies what a student has written, and nothing that was built."""

from __future__ import annotations

import os
import shutil
import stat
from pathlib import Path

from sdc_workshop.workspace import MARKER, PACKAGE, PROJECT, WORLD

LARGEST_FILE_B = 20_000_000
LARGEST_SUM_B = 200_000_000
_LEFT_OUT = {".git", "__pycache__", "build", "devel", "install"}


class CopyError(ValueError):
    """A folder that cannot be graded; the message says why."""


def is_workspace(folder: Path) -> bool:
    """Whether a student's package lies in this folder."""
    return (folder / "src" / PACKAGE).is_dir()


def copy_workspace(source: Path, target: Path) -> None:
    """Make a workspace in `target` from the package that a student has written in `source`, with the project's own world beside it.
    Nothing in `source` is changed. Raises CopyError, and OSError for what cannot be read."""
    package = source / "src" / PACKAGE
    if not package.is_dir():
        raise CopyError(f"{source} is no workspace: it has no src/{PACKAGE}")
    target.mkdir(parents=True)
    _copy(package, target / "src" / PACKAGE)
    shutil.copytree(WORLD, target / "src" / WORLD.name)
    os.symlink(PROJECT / "workshop", target / "workshop")
    (target / MARKER).write_text(f"{PROJECT}\n", encoding="utf-8")


def _copy(source: Path, target: Path) -> None:
    """Regular files and folders; what a link leads to is copied, but no folder twice. Pipes and devices would never end: left out."""
    size = 0
    seen = set()
    for folder, names, files in os.walk(source, followlinks=True):
        place = os.path.realpath(folder)
        if place in seen:
            names.clear()
            continue
        seen.add(place)
        names[:] = [name for name in names if name not in _LEFT_OUT]
        to = target / Path(folder).relative_to(source)
        to.mkdir(parents=True, exist_ok=True)
        for name in files:
            path = Path(folder, name)
            try:
                found = path.stat()
            except OSError:
                continue
            if not stat.S_ISREG(found.st_mode) or found.st_size > LARGEST_FILE_B:
                continue
            size += found.st_size
            if size > LARGEST_SUM_B:
                raise CopyError(
                    f"src/{PACKAGE} holds more than {LARGEST_SUM_B // 1_000_000} MB; delete what does not belong there"
                )
            shutil.copyfile(path, to / name)
            (to / name).chmod(stat.S_IMODE(found.st_mode) | 0o600)
