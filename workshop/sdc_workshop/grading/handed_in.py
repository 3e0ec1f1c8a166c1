"""Find each student's work in a folder of any layout, or in a zip, and copy what they wrote."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import zipfile
from pathlib import Path
from typing import Iterable

from sdc_workshop.steps import WORKSHOP
from sdc_workshop.student_file import read_anyway
from sdc_workshop.workspace import WorkspaceError, copy_car, is_older, link, package_of, update

_MAX_TOTAL_BYTES = 200_000_000
_MAX_ENTRIES = 20_000
# Folders that hold nothing that a student has written, and the files before an update.
_LEFT_OUT = {".git", "__MACOSX", "__pycache__", "build", "devel", "install"}
_BEFORE_UPDATE = "before_update_"
_DEPTH = 16
# Deeper folders are more than a package has, and than Python can copy.
_MAX_DEPTH = 60
_MAX_ZIPS = 3  # a zip in a zip in a zip
_OTHER_ARCHIVES = (".7z", ".rar", ".tar", ".tgz", ".gz", ".xz", ".bz2")
# How Moodle and Canvas name the files of "download all submissions".
_DOWNLOADED = (
    (re.compile(r"(.+)_(\d+)_assignsubmission_.*"), "Full name", "Identifier", "Participant {}"),
    (re.compile(r"([^_]+)(?:_LATE)?_(\d+)_\d+_.*"), "Student", "ID", "{}"),
)


class HandedInError(ValueError):
    """Work that cannot be graded; the message is one line with the reason."""


def submissions(folders: Iterable[Path], output: Path, lab: str = WORKSHOP) -> list:
    """Return what each student has handed in, as absolute paths without duplicates.

    A folder, or a zip, is of a student, or a folder of a class contains these. `output`, with the
    summary, is no student's.
    """
    name, found = package_of(lab), []
    for folder in (Path(os.path.normpath(folder.absolute())) for folder in folders):
        own = ("", name, f"src/{name}", f"sdc_ws/src/{name}")
        is_student = any(_is_package(folder / path, name) for path in own)
        inside = [] if is_student or not folder.is_dir() else sorted(folder.iterdir())
        entries = [path for path in inside if path != output and path.name[0] != "."]
        found.extend([path for path in entries if path.name not in _LEFT_OUT] or [folder])
    return list(dict.fromkeys(found))


def names(paths: list, taken: Iterable[str] = ()) -> dict:
    """Return a unique name, none of `taken`, for each path: the last parts, as few as possible."""
    parts = {path: (*path.parts[1:-1], lms_columns(path)[0]) for path in paths}
    found: dict = {}
    for path, own in parts.items():
        ends = ([other[-count:] for other in parts.values()] for count in range(1, len(own)))
        count = next((n for n, end in enumerate(ends, 1) if end.count(own[-n:]) == 1), len(own))
        # A name is a line of the table and a folder: no line break, no slash.
        name = re.sub(r"[^\w .@+-]", "_", "_".join(own[-count:])) or "root"
        while name in (*taken, *found.values()):
            name += "_"
        found[path] = name
    return found


def lms_columns(path: Path) -> tuple[str, dict]:
    """Return a student's name, and what Moodle or Canvas wrote about them into a file name."""
    name = path.stem if path.suffix.lower() == ".zip" else path.name
    for pattern, name_column, id_column, form in _DOWNLOADED:
        match = pattern.fullmatch(path.name)
        if match:
            return match[1], {name_column: match[1], id_column: form.format(match[2])}
    return name, {}


def find_package(handed_in: Path, temporary: Path, lab: str = WORKSHOP) -> tuple[Path, Path]:
    """Return the package in a folder or a zip, and the folder that links in it must not leave.

    A zip is unpacked into `temporary`, which does not exist yet.

    Raises:
        HandedInError: there is no package, or more than one; or a zip is not safe
        OSError: a folder cannot be read
    """
    name, root = package_of(lab), handed_in
    if handed_in.is_symlink():
        raise HandedInError(f"{handed_in} is a link to another place; put the folder itself there")
    found, zips = _content(root, name)
    if root.is_file():
        zips = [root]
    for level in range(_MAX_ZIPS):
        if len(zips) > 1 and not found:
            listed = ", ".join(path.name for path in zips[:3])
            raise HandedInError(f"{handed_in} has {len(zips)} zips: {listed}; keep one of them")
        if zips and not found:
            root = _unpacked(zips[0], temporary / str(level))
            found, zips = _content(root, name)
    if not found:
        inside = f" in its first {_DEPTH} levels of folders"
        if zips:
            inside = f", but zips in {_MAX_ZIPS} zips; hand in one zip"
        raise HandedInError(f"{handed_in} is no workspace: it has no src/{name}{inside}")
    if len(found) > 1:
        places = ", ".join(str(path.relative_to(root)) for path in found[:3])
        raise HandedInError(f"{handed_in} has more than one {name}: {places}; keep one of them")
    return found[0], root


def _content(root: Path, name: str) -> tuple[list, list]:
    """Return the packages with this name that are nearest to a folder, and the zips below it.

    Without a zip, return an archive of another kind, which is no zip that opens.
    """
    found: dict = {}
    links, zips, others = [], [], []
    for place, names, files in os.walk(root):
        folder = Path(place)
        depth = len(folder.relative_to(root).parts)
        if _is_package(folder, name):
            found.setdefault(depth, []).append(folder)
        names[:] = [
            one
            for one in sorted(names)
            if one not in _LEFT_OUT and not one.startswith(_BEFORE_UPDATE) and depth < _DEPTH
        ]
        links += [folder / one for one in names if (folder / one).is_symlink()]
        # Of a file NAME, macOS also packs ._NAME.
        paths = [folder / one for one in sorted(files) if one[0] != "."]
        paths = [path for path in paths if path.is_file() and not path.is_symlink()]
        zips += [path for path in paths if path.suffix.lower() == ".zip"]
        others += [path for path in paths if path.suffix.lower() in _OTHER_ARCHIVES]
    for path in links if not found else ():
        if path.name != "workshop":
            raise HandedInError(f"{path} is a link to another place; put the package itself there")
    return (found[min(found)] if found else []), zips or others[:1]


def _is_package(folder: Path, name: str) -> bool:
    """Return whether a folder is a package, under its own name or renamed."""
    manifest = folder / "package.xml"
    # os.path: where a folder cannot be read, the grade of its student says it.
    if not os.path.isdir(folder) or folder.is_symlink():
        return False
    if folder.name == name or not os.path.isfile(manifest):
        return folder.name == name
    return f"<name>{name}</name>" in read_anyway(manifest)


def _unpacked(archive: Path, folder: Path) -> Path:
    """Unpack a zip into a new folder, with the permissions to execute, and return the folder.

    A link becomes a file with its text. Raises HandedInError where the zip is too large unpacked,
    and where it is no zip.
    """
    try:
        with zipfile.ZipFile(archive) as content:
            members = [member for member in content.infolist() if not member.is_dir()]
            size = sum(member.file_size for member in members)
            if size > _MAX_TOTAL_BYTES or len(members) > _MAX_ENTRIES:
                raise HandedInError(
                    f"{archive} is too large unpacked ({size // 1_000_000} MB, {len(members)} "
                    f"files); at most {_MAX_TOTAL_BYTES // 1_000_000} MB and {_MAX_ENTRIES} files"
                )
            if any(member.filename.count("/") > _MAX_DEPTH for member in members):
                raise HandedInError(f"{archive} has folders in more than {_MAX_DEPTH} levels")
            for member in members:
                member.filename = member.filename.replace("\\", "/")
                # It leaves out what leads out of the folder: "..", and "/" at the beginning.
                written, mode = Path(content.extract(member, folder)), member.external_attr >> 16
                # A zip made on Windows has no permissions.
                is_program = mode & 0o100 if mode else written.read_bytes()[:2] == b"#!"
                written.chmod(0o755 if is_program else 0o644)
    except HandedInError:
        raise
    except Exception as error:  # noqa: BLE001  each way to compress has errors of its own
        raise HandedInError(f"{archive}: neither a folder nor a zip that opens ({error})") from None
    return folder


def copy_workspace(source: Path, target: Path, lab: str = WORKSHOP) -> list:
    """Create a workspace with a copy of a student's package. The source is not changed.

    The workspace of a lab gets the finished car: its marks do not depend on the student's car.
    Return the links to folders and to places outside of the workspace, which are not copied: they
    may lead to files of the teacher or of another student, or in a circle.

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
        if len(Path(folder).relative_to(source).parts) > _MAX_DEPTH:
            raise HandedInError(f"{source} has folders in more than {_MAX_DEPTH} levels")
        paths = [Path(folder, name) for name in names]
        links.extend(str(path) for path in paths if path.is_symlink() and leads_away(path))
        files = [path for path in paths if path.is_file() and str(path) not in links]
        folders = [path for path in paths if path.is_dir() and not path.is_symlink()]
        size += sum(path.stat().st_size for path in files)
        if size > _MAX_TOTAL_BYTES:
            raise HandedInError(
                f"{source} is larger than {_MAX_TOTAL_BYTES // 1_000_000} MB; "
                "delete what does not belong there"
            )
        kept = {path.name for path in (*files, *folders)} - _LEFT_OUT
        return [name for name in names if name not in kept]

    def leads_away(path: Path) -> bool:
        return path.is_dir() or inside not in Path(os.path.realpath(path)).parents

    shutil.copytree(source, target, ignore=left_out)
    for path in (target, *target.rglob("*")):
        path.chmod(0o755 if path.is_dir() or os.access(path, os.X_OK) else 0o644)
    return links
