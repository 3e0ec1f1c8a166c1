"""Grade on a Dask cluster: each workspace is a task, and all machines share the folders."""

from __future__ import annotations

import contextlib
import secrets
from dataclasses import replace
from pathlib import Path
from typing import Iterator, Sequence

from sdc_experiments.sandbox import SandboxError
from sdc_experiments.sweep.dask_engine import DaskEngine
from sdc_workshop.exam.sandbox import require
from sdc_workshop.grading.grading import Conditions, Grade, grade
from sdc_workshop.workspace import PROJECT, WORLD_SETUP

# Name of a file that the workers must see. While it exists, the command that grades runs.
_TOKEN = "grading_{}.token"


def grade_on_cluster(
    scheduler: str, jobs: Sequence, output: Path, sandboxed: bool
) -> Iterator[Grade]:
    """Grade the jobs (name, workspace, Conditions); yield each grade as soon as it is known.

    Raises:
        ClusterError: the cluster cannot grade; the message is one line with the fix
    """
    folders = {name: folder for name, folder, _ in jobs}
    token = output / _TOKEN.format(secrets.token_hex())
    token.touch()
    try:
        with DaskEngine(scheduler) as engine:
            engine.check(worker_problem, str(token), sandboxed)
            if not engine.workers:
                print("grade: the cluster has no worker yet; the workspaces wait for one")
            tasks = (
                (name, (name, str(folder), folder.exists(), str(token), conditions))
                for name, folder, conditions in jobs
            )
            for outcome in engine.outcomes(grade_as_task, tasks):
                note = f"the check ended without a result: {outcome.error}"
                yield outcome.result or Grade(outcome.key, folders[outcome.key], note=note)
    finally:
        # Checks that still run end when they miss it.
        with contextlib.suppress(FileNotFoundError):
            token.unlink()


def worker_problem(token: str, sandboxed: bool) -> str:
    """Return why this process cannot grade, or ""; the token is in the folder of the summary."""
    output = Path(token).parent
    if not Path(token).is_file():
        return (
            f"it does not see {output}; put the workspaces and --output into a folder that "
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
    name: str, folder: str, exists: bool, token: str, conditions: Conditions
) -> Grade:
    """Grade a student's workspace on a worker; `exists` if the command that grades sees it."""
    problem = worker_problem(token, conditions.user_id is not None)
    if not problem and exists and not Path(folder).exists():
        problem = f"the worker does not see {folder}; put it into a folder that all workers share"
    if problem:
        return Grade(name, Path(folder), note=problem)
    conditions = replace(conditions, stopped=lambda: not Path(token).exists())
    return grade(name, Path(folder), Path(token).parent / name, conditions)
