"""Copy what a student has written, and nothing that was built."""

from __future__ import annotations

import contextlib
import os
import shutil
import stat
from pathlib import Path

from sdc_workshop.grading.handed_in import (
    LEFT_OUT,
    MAX_FILE_BYTES,
    MAX_TOTAL_BYTES,
    HandedInError,
    find_package,
)
from sdc_workshop.steps import WORKSHOP
from sdc_workshop.workspace import WorkspaceError, copy_car, is_older, link, package_of, update


def copy_workspace(source: Path, target: Path, lab: str = WORKSHOP) -> list:
    """Create a workspace with a copy of a student's package. The source is not changed.

    The workspace of a lab gets the finished car: its marks do not depend on the student's car.

    Args:
        source: what the student has handed in, see find_package
        target: folder of the new workspace
        lab: the lab

    Returns:
        the links to places outside of the workspace, which are not copied: they may lead to files
        of the teacher or of another student

    Raises:
        HandedInError: there is no package in the source, or it is too large
        OSError: a file cannot be read
    """
    package, root = find_package(source, target.with_name("handed_in"), lab)
    target.mkdir(parents=True)
    left_out = _copy(package, target / "src" / package_of(lab), Path(os.path.realpath(root)))
    if lab:
        copy_car(target)
    link(target, lab)
    if is_older(package.parent.parent):
        # A file whose TODO lines do not match stays as it is; its check reports the line.
        with contextlib.suppress(WorkspaceError):
            update(target)
    return left_out


def _copy(source: Path, target: Path, inside: Path) -> list:
    """Copy regular files and folders, and what links point to; leave out pipes and devices.

    A folder is copied once, so that cycles of links end. Other users can read the copy: the
    student's programs may run as one. Return the links that lead out of `inside`.
    """
    size = 0
    seen = set()
    left_out = []

    def leads_out(path: Path) -> bool:
        return path.is_symlink() and inside not in Path(os.path.realpath(path)).parents

    for folder, names, files in os.walk(source, followlinks=True):
        place = os.path.realpath(folder)
        if place in seen:
            names.clear()
            continue
        seen.add(place)
        links = [name for name in (*names, *files) if leads_out(Path(folder, name))]
        left_out += [str(Path(folder, name)) for name in links]
        names[:] = [name for name in names if name not in LEFT_OUT and name not in links]
        to = target / Path(folder).relative_to(source)
        to.mkdir(parents=True, exist_ok=True)
        for name in files:
            path = Path(folder, name)
            if name in links:
                continue
            try:
                found = path.stat()
            except OSError:
                continue
            if not stat.S_ISREG(found.st_mode) or found.st_size > MAX_FILE_BYTES:
                continue
            size += found.st_size
            if size > MAX_TOTAL_BYTES:
                raise HandedInError(
                    f"{source} is larger than {MAX_TOTAL_BYTES // 1_000_000} MB; "
                    "delete what does not belong there"
                )
            shutil.copyfile(path, to / name)
            for_all = 0o755 if found.st_mode & stat.S_IXUSR else 0o644
            (to / name).chmod(stat.S_IMODE(found.st_mode) | for_all)
    return left_out
