"""Copy what a student has written, and nothing that was built."""

from __future__ import annotations

import contextlib
import os
import shutil
from pathlib import Path

from sdc_workshop.grading.handed_in import (
    LEFT_OUT,
    MAX_DEPTH,
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
        the links to folders and to places outside of the workspace, which are not copied: they may
        lead to files of the teacher or of another student, or in a circle

    Raises:
        HandedInError: there is no package in the source, or it is too large
        OSError: a file cannot be read
    """
    package, root = find_package(source, target.with_name("handed_in"), lab)
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
    """Copy regular files and folders, and files in `inside` that links point to.

    Other users can read the copy: the student's programs may run as one. Return the links that are
    left out.
    """
    size = 0
    links: list = []

    def left_out(folder: str, names: list) -> list:
        nonlocal size
        if len(Path(folder).relative_to(source).parts) > MAX_DEPTH:
            raise HandedInError(f"{source} has folders in more than {MAX_DEPTH} levels")
        paths = [Path(folder, name) for name in names]
        links.extend(str(path) for path in paths if path.is_symlink() and leads_away(path))
        files = [path for path in paths if path.is_file() and str(path) not in links]
        folders = [path for path in paths if path.is_dir() and not path.is_symlink()]
        size += sum(path.stat().st_size for path in files)
        if size > MAX_TOTAL_BYTES:
            raise HandedInError(
                f"{source} is larger than {MAX_TOTAL_BYTES // 1_000_000} MB; "
                "delete what does not belong there"
            )
        kept = {path.name for path in (*files, *folders)} - LEFT_OUT
        return [name for name in names if name not in kept]

    def leads_away(path: Path) -> bool:
        return path.is_dir() or inside not in Path(os.path.realpath(path)).parents

    shutil.copytree(source, target, ignore=left_out)
    for path in (target, *target.rglob("*")):
        path.chmod(0o755 if path.is_dir() or os.access(path, os.X_OK) else 0o644)
    return links
