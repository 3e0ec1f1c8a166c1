"""A student's workspace in which all steps are solved, built as a student builds it."""

from sdc_testing import program
from sdc_workshop.exam.student import Student
from sdc_workshop.regions import regions
from sdc_workshop.steps import LABS, WORKSHOP, load_steps
from sdc_workshop.workspace import PROJECT, WORLD_SETUP, make, package_files, solution, solve


def differences(folder, lab=WORKSHOP):
    """Return the package files of a workspace that are missing or differ from the solution."""
    return [
        name
        for name in package_files(lab)
        if not (folder / "src" / name).is_file()
        or (folder / "src" / name).read_bytes() != solution(name).read_bytes()
    ]


def is_given(step):
    """Return whether a workspace has the lines of a step from the start."""
    text = solution(step.file).read_text(encoding="utf-8") if step.todo else ""
    return step.todo in regions(text) and regions(text)[step.todo].given


def finished(folder, *labs):
    """Create it in `folder`, a path that does not exist, with the packages of labs, not built."""
    for lab in labs or (WORKSHOP,):
        make(folder, lab)
        for step in load_steps(lab):
            solve(folder, step)
    return folder


def solved(folder):
    """Create it with the packages of all labs, and build it."""
    build(finished(folder, WORKSHOP, *LABS))
    return folder


def build(folder, setup=WORLD_SETUP):
    """Build a workspace in a new terminal that has sourced `setup`: Python's messages alone."""
    prepared = program.run(PROJECT / "docker" / "prepare", "world")
    assert prepared.returncode == 0, prepared.stdout
    python_only = {"ROS_LANG_DISABLE": "gencpp:genlisp:geneus:gennodejs"}
    terminal = {"HOME": str(folder), "PATH": "/usr/bin:/bin", **python_only}
    command = "bash", "-c", '[ -z "$1" ] || source "$1"; catkin_make', "bash", setup or ""
    done = program.run(*command, folder=folder, environment=terminal)
    assert done.returncode == 0, done.stdout


def run(folder, *command):
    """Run a command in a new terminal that has sourced a workspace."""
    return program.run(*command, environment=Student(folder).environment)
