"""Grade on a Dask cluster: each workspace is a task, and all machines share the folders."""

from __future__ import annotations

import contextlib
import secrets
from pathlib import Path
from typing import Iterator, Mapping

from sdc_experiments.sweep.dask_engine import DaskEngine
from sdc_workshop.exam.sandbox import SandboxError, require, user_id
from sdc_workshop.grading.grading import Conditions, Grade, grade
from sdc_workshop.workspace import PROJECT, WORLD_SETUP

# A file that the workers must see. While it exists, the command that grades runs.
_TOKEN = "grading.token"


def grade_on_cluster(
    scheduler: str,
    named: Mapping[Path, str],
    output: Path,
    limit_s: float,
    sandboxed: bool,
    lab: str,
) -> Iterator[Grade]:
    """Grade workspaces and yield each grade as soon as it is known.

    Args:
        scheduler: address tcp://HOST:PORT of the cluster
        named: name of each workspace
        output: folder of the summary
        limit_s: time limit of a student [s]
        sandboxed: whether the students' programs run in a sandbox
        lab: the lab, or WORKSHOP

    Raises:
        ClusterError: the cluster cannot grade; the message is one line with the fix
    """
    folders = {name: folder for folder, name in named.items()}
    token = output / _TOKEN
    token.write_text(secrets.token_hex(), encoding="utf-8")
    try:
        with DaskEngine(scheduler) as engine:
            conditions = (str(token), token.read_text(encoding="utf-8"), sandboxed)
            engine.check(worker_problem, *conditions)
            if not engine.workers:
                print("grade: the cluster has no worker yet; the workspaces wait for one")
            tasks = (
                (name, (name, str(folder), folder.exists(), number, limit_s, lab, *conditions))
                for number, (name, folder) in enumerate(folders.items())
            )
            for outcome in engine.outcomes(grade_as_task, tasks):
                note = f"the check ended without a result: {outcome.error}"
                yield outcome.result or Grade(outcome.key, folders[outcome.key], note=note)
    finally:
        # Checks that still run end when they miss it.
        with contextlib.suppress(FileNotFoundError):
            token.unlink()


def worker_problem(token_path: str, token: str, sandboxed: bool) -> str:
    """Return why this process cannot grade, or "".

    Args:
        token_path: a file in the folder of the summary
        token: its content
        sandboxed: whether the students' programs run in a sandbox
    """
    path = Path(token_path)
    if not path.is_file() or path.read_text(encoding="utf-8") != token:
        return (
            f"it does not see {path.parent}; put the workspaces and --output into a folder that "
            "all workers share, with the same path on each machine"
        )
    if not Path(WORLD_SETUP).is_file():
        return f"the world is not built; run there: {PROJECT}/docker/prepare"
    try:
        if sandboxed:
            require()
    except SandboxError as error:
        return str(error)
    return ""


def grade_as_task(
    name: str,
    folder: str,
    exists: bool,
    number: int,
    limit_s: float,
    lab: str,
    token_path: str,
    token: str,
    sandboxed: bool,
) -> Grade:
    """Grade one workspace on a worker.

    Args:
        name: name of the student
        folder: the workspace
        exists: whether the command that grades sees the folder
        number: number of the student
        limit_s: time limit of the student [s]
        lab: see `grade_on_cluster`
        token_path: see `worker_problem`
        token: see `worker_problem`
        sandboxed: see `worker_problem`
    """
    problem = worker_problem(token_path, token, sandboxed)
    if not problem and exists and not Path(folder).exists():
        problem = f"the worker does not see {folder}; put it into a folder that all workers share"
    if problem:
        return Grade(name, Path(folder), note=problem)
    user = user_id(number) if sandboxed else None
    conditions = Conditions(limit_s, user, lambda: not Path(token_path).exists(), lab=lab)
    return grade(name, Path(folder), Path(token_path).parent / name, conditions)
