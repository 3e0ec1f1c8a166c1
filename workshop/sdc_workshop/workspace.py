"""A student's workspace: create one, and write the solution of a step into it."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from pathlib import Path

from sdc_workshop.regions import RegionError, is_written, regions, replaced, template
from sdc_workshop.regions import body as region_body
from sdc_workshop.steps import LABS, WORKSHOP, Step, load_steps
from sdc_workshop.student_file import FileError, read, read_anyway, values

PROJECT = Path(__file__).resolve().parents[2]
SOLUTION = PROJECT / "catkin_ws" / "src"
# The workspace of the world's packages, which docker/prepare builds; a student's one overlays it.
WORLD = PROJECT / "world_ws"
WORLD_SETUP = WORLD / "devel" / "setup.bash"
PACKAGE = "sdc_package"
MARKER = ".workshop"
# In a package: the steps that `./workshop/check --solution` wrote.
_SOLVED = ".solutions"
# Students get neither the tests of the solution nor the README that explains it.
_LEFT_OUT = ("test", "README.md", "__pycache__")
# The command that restores the given lines of a workspace, for people.
UPDATE = "`./workshop/start --update .` in your workspace"


class WorkspaceError(ValueError):
    """A folder that is no workspace, or cannot become one; the message names the fix."""


def package_of(lab: str) -> str:
    """Return the package that a student writes in a lab, or in the workshop."""
    return LABS[lab] if lab else PACKAGE


def solution(name: str) -> Path:
    """Return the solution's file with this path relative to the src folder of a workspace."""
    in_labs = Path(name).parts[0] in LABS.values()
    return SOLUTION / "labs" / name if in_labs else SOLUTION / name


def solution_text(name: str) -> str:
    """Return the text of the solution's file."""
    return solution(name).read_text(encoding="utf-8")


def package_files(lab: str = WORKSHOP) -> list:
    """Return all files of a finished package, relative to the src folder, sorted."""
    root = solution(package_of(lab))
    found = (path.relative_to(root.parent) for path in root.rglob("*") if path.is_file())
    return sorted(
        str(path)
        for path in found
        if not set(path.parts) & set(_LEFT_OUT) and path.suffix != ".pyc"
    )


def files_to_make(lab: str = WORKSHOP) -> set:
    """Return the files that a student writes from scratch, relative to the src folder."""
    return {step.file for step in load_steps(lab) if step.file and step.todo is None}


def template_of(name: str) -> str | None:
    """Return the solution's file with empty TODOs; None for a file without TODOs."""
    is_text = name.endswith((".py", ".launch", ".xml", ".txt", ".sh", ".msg", ".yaml"))
    text = solution_text(name) if is_text else ""
    return template(text) if regions(text) else None


def make(folder: Path, lab: str = WORKSHOP) -> None:
    """Create a student's workspace: the package with empty TODOs, and a link to the workshop.

    The workspace of a lab also contains the finished car. A workspace of the workshop keeps its own
    car, and gets the package of the lab. Any other folder must be empty, or not exist yet.

    Raises:
        WorkspaceError: the folder is not empty, or lies in the project's own workspace
    """
    folder = folder.absolute()
    if folder.exists() and not folder.is_dir():
        raise WorkspaceError(f"{folder} is a file; name a new folder")
    is_workspace = (folder / MARKER).is_file()
    if is_workspace and not lab:
        raise WorkspaceError(
            f"{folder} is a workspace already; ./workshop/start --update {folder} brings it to "
            "this version, and keeps what is written at the TODOs"
        )
    if is_workspace and (folder / "src" / package_of(lab)).exists():
        raise WorkspaceError(f"{folder} already has src/{package_of(lab)}")
    if not is_workspace and folder.is_dir() and any(folder.iterdir()):
        raise WorkspaceError(f"{folder} is not empty; name a new folder, or empty this one")
    if {PROJECT / "catkin_ws", WORLD} & set(folder.resolve().parents):
        raise WorkspaceError(
            f"{folder} lies in the project's own workspace; "
            "name a folder elsewhere, such as ~/sdc_ws"
        )
    if lab and not is_workspace:
        copy_car(folder)
    for name in package_files(lab):
        if name not in files_to_make(lab):
            _write_given(folder, name, template_of(name))
    if is_workspace:
        _mark(folder, lab)
    else:
        link(folder, lab)


def copy_car(folder: Path) -> None:
    """Copy the finished car into a workspace."""
    for name in package_files():
        _write_given(folder, name, None)


def _write_given(folder: Path, name: str, text: str | None) -> None:
    """Write a file that students get: a text, or the solution where that is None."""
    to = folder / "src" / name
    to.parent.mkdir(parents=True, exist_ok=True)
    if text is None:
        shutil.copy(solution(name), to)
    else:
        to.write_text(text, encoding="utf-8")


def update(folder: Path) -> tuple:
    """Bring the given files and lines of a workspace to this version; the TODOs stay as they are.

    Returns:
        the files that were written, relative to src, and the folder with a copy of the old files,
        in which the lines of a TODO that has moved to another file are

    Raises:
        WorkspaceError: the TODO lines and rules of a file do not match; nothing is written
    """
    wanted: dict = {}
    for lab in (WORKSHOP, *LABS):
        if (folder / "src" / package_of(lab)).is_dir():
            for name in set(package_files(lab)) - files_to_make(lab):
                wanted[name] = _updated(folder, name)
    old = {name: folder / "src" / name for name in wanted}
    changed = sorted(
        name
        for name, text in wanted.items()
        if not old[name].is_file() or text != read_anyway(old[name])
    )
    copy = Path(tempfile.mkdtemp(prefix="before_update_", dir=folder)) if changed else folder
    for name in changed:
        if old[name].is_file():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(old[name], copy / name)
        _write_given(folder, name, wanted[name])
    _mark(folder, lab_of(folder))
    return changed, copy


def version() -> str:
    """Return a text that changes with any file or line that students get."""
    given = hashlib.sha256()
    for name in (name for lab in (WORKSHOP, *LABS) for name in package_files(lab)):
        given.update((template_of(name) or solution_text(name)).encode())
    return given.hexdigest()[:12]


def is_older(folder: Path) -> bool:
    """Return whether a workspace was made by, or updated to, another version of the workshop."""
    marker = folder / MARKER
    return marker.is_file() and version() not in read_anyway(marker).split("\n")


def _updated(folder: Path, name: str) -> str:
    """Return this version of a file, with the student's regions and configuration."""
    new = solution_text(name)
    path = folder / "src" / name
    empty = template_of(name)
    try:
        own = read(folder / "src", name) if path.is_file() else None
        if empty is None:
            return str(own) if own is not None and _has_all_keys(name, own, new) else new
        written = regions(own or "")
    except RegionError as error:
        raise WorkspaceError(f"src/{name}: {error}") from None
    for number, region in regions(empty).items():
        if number in written and (not region.given or is_written(str(own), number)):
            empty = replaced(empty, number, region_body(str(own), number))
    return empty


def _has_all_keys(name: str, own: str, new: str) -> bool:
    """Return whether this is a configuration, which students tune, with all keys of the new one."""
    if Path(name).parent.name != "config" or not name.endswith(".yaml"):
        return False
    return set(values(own)) >= set(values(new))


def link(folder: Path, lab: str = WORKSHOP) -> None:
    """Connect a workspace with the project: a link to the workshop, and the marker file."""
    os.symlink(PROJECT / "workshop", folder / "workshop")
    _mark(folder, lab)


def _mark(folder: Path, lab: str) -> None:
    (folder / MARKER).write_text(f"{PROJECT}\n{lab}\n{version()}\n", encoding="utf-8")


def lab_of(folder: Path) -> str:
    """Return the lab that a workspace was last made for, or WORKSHOP."""
    lab = read_anyway(folder / MARKER).split("\n")[1:2]
    return lab[0] if lab and lab[0] in LABS else WORKSHOP


def lab_near(place: Path) -> str:
    """Return the lab of the workspace that contains a folder; WORKSHOP where none does."""
    try:
        return lab_of(find(place))
    except WorkspaceError:
        return WORKSHOP


def find(start: Path) -> Path:
    """Return the student's workspace that contains a folder. Raises WorkspaceError."""
    start = start.absolute()
    for folder in (start, *start.parents):
        if (folder / MARKER).is_file():
            return folder
    raise WorkspaceError(
        f"{start} is in no workspace of the workshop; "
        "cd to yours, or create one with ./workshop/start DIR"
    )


def solution_body(step: Step) -> str:
    """Return the solution's lines of this step's region, or of the whole file."""
    text = solution_text(str(step.file))
    return region_body(text, step.todo) if step.todo else text


def write(folder: Path, step: Step, new_body: str) -> None:
    """Write a body into this step's region of a workspace, or the whole file.

    Other regions and permissions are kept. Raises RegionError where the TODO line or the rule of
    the region is missing.
    """
    path = folder / "src" / str(step.file)
    if step.todo:
        try:
            new_body = replaced(read(folder / "src", str(step.file)), step.todo, new_body)
        except FileError as error:
            raise WorkspaceError(f"src/{step.file}: {error}") from None
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(new_body, encoding="utf-8")


def note_solution(folder: Path, step: Step) -> None:
    """Note in the student's package that the solution of a step was written into it."""
    with (folder / "src" / package_of(step.lab) / _SOLVED).open("a", encoding="utf-8") as file:
        file.write(f"{step.id}\n")


def solved_steps(folder: Path, lab: str = WORKSHOP) -> list:
    """Return the ids of the noted steps that are still as in the solution."""
    path = folder / "src" / package_of(lab) / _SOLVED
    noted = read_anyway(path).split() if path.is_file() else []
    return [step.id for step in load_steps(lab) if step.id in noted and _is_solved(folder, step)]


def _is_solved(folder: Path, step: Step) -> bool:
    try:
        text = read(folder / "src", str(step.file))
        own = region_body(text, step.todo) if step.todo else text
    except (OSError, KeyError, RegionError):
        return False
    return own == solution_body(step)


def solve(folder: Path, step: Step) -> None:
    """Write the solution of one step, and make the file executable where the solution's is."""
    if step.file is None:
        return
    write(folder, step, solution_body(step))
    if os.access(solution(step.file), os.X_OK):
        path = folder / "src" / step.file
        path.chmod(path.stat().st_mode | 0o111)
