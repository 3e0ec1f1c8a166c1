"""A student's workspace: making one, and applying the solution of a step to one."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from sdc_workshop.regions import body as region_body
from sdc_workshop.regions import regions, replaced, template
from sdc_workshop.steps import Step, load_steps

PROJECT = Path(__file__).resolve().parents[2]
SOLUTION = PROJECT / "catkin_ws" / "src"
TEMPLATES = PROJECT / "workshop" / "templates"
WORLD = PROJECT / "workshop" / "sdc_world"
PACKAGE = "sdc_package"
MARKER = ".workshop"
# What a student has no part in: the tests of the solution, and the README that explains it.
_LEFT_OUT = ("test", "README.md", "__pycache__")


class WorkspaceError(ValueError):
    """A folder that is no workspace, or cannot become one; the message says how to mend it."""


def package_files() -> list:
    """All files of a finished workspace, relative to its src folder, sorted."""
    root = SOLUTION / PACKAGE
    found = (path.relative_to(SOLUTION) for path in root.rglob("*") if path.is_file())
    return sorted(
        str(path)
        for path in found
        if not set(path.parts) & set(_LEFT_OUT) and path.suffix != ".pyc"
    )


def files_to_make() -> set:
    """The files that a student makes from nothing, relative to the src folder."""
    return {step.file for step in load_steps() if step.file and step.todo is None}


def derived_templates() -> dict:
    """{file relative to the src folder: text} of all files with regions in them, nothing solved."""
    found = {}
    for name in package_files():
        text = (SOLUTION / name).read_text(encoding="utf-8") if _is_text(name) else ""
        if regions(text):
            found[name] = template(text)
    return found


def _is_text(name: str) -> bool:
    return name.endswith((".py", ".launch", ".xml", ".txt", ".sh", ".msg", ".yaml"))


def make(folder: Path) -> None:
    """Make a student's workspace: the package with nothing solved, the package that lends it the project's world, a link to the workshop,
    and a marker that says where the project is. Raises WorkspaceError for a folder that is not empty or that lies in the project's own
    workspace."""
    folder = folder.absolute()
    if folder.exists() and not folder.is_dir():
        raise WorkspaceError(f"{folder} is a file; name a new folder")
    if folder.is_dir() and any(folder.iterdir()):
        raise WorkspaceError(f"{folder} is not empty; name a new folder, or empty this one")
    if (PROJECT / "catkin_ws") in folder.resolve().parents:
        raise WorkspaceError(
            f"{folder} lies in the project's own workspace; name a folder elsewhere, such as ~/sdc_ws"
        )
    created = files_to_make()
    for name in package_files():
        if name in created:
            continue
        to = folder / "src" / name
        to.parent.mkdir(parents=True, exist_ok=True)
        if (TEMPLATES / name).exists():
            shutil.copyfile(TEMPLATES / name, to)
        else:
            shutil.copy(SOLUTION / name, to)
    shutil.copytree(WORLD, folder / "src" / WORLD.name)
    os.symlink(PROJECT / "workshop", folder / "workshop")
    (folder / MARKER).write_text(f"{PROJECT}\n", encoding="utf-8")


def find(start: Path) -> Path:
    """The student's workspace that a folder lies in. Raises WorkspaceError."""
    start = start.absolute()
    for folder in (start, *start.parents):
        if (folder / MARKER).is_file():
            return folder
    raise WorkspaceError(
        f"{start} lies in no workspace of the workshop; cd to yours, or make one with ./workshop/start DIR"
    )


def solution_body(step: Step) -> str:
    """What the solution has in this step's region, or in the whole file."""
    text = (SOLUTION / step.file).read_text(encoding="utf-8")
    return region_body(text, step.todo) if step.todo else text


def write(folder: Path, step: Step, new_body: str) -> None:
    """Write a body into this step's region of the workspace, or the whole file. Raises RegionError where the region's TODO line or
    rule is gone. Other regions, and permissions, stay as they are."""
    path = folder / "src" / step.file
    if step.todo:
        new_body = replaced(path.read_text(encoding="utf-8"), step.todo, new_body)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(new_body, encoding="utf-8")


def solve(folder: Path, step: Step) -> None:
    """Apply the solution of one step, with the permission to run the file where the solution has it."""
    if step.file is None:
        return
    write(folder, step, solution_body(step))
    if os.access(SOLUTION / step.file, os.X_OK):
        path = folder / "src" / step.file
        path.chmod(path.stat().st_mode | 0o111)


def differences(folder: Path) -> list:
    """The files of the package that are missing in a workspace or not equal to the solution, byte for byte."""
    return [
        name
        for name in package_files()
        if not (folder / "src" / name).is_file()
        or (folder / "src" / name).read_bytes() != (SOLUTION / name).read_bytes()
    ]
