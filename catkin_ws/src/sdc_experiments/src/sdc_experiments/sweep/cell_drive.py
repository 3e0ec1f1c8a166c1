"""Drive one cell of a study, in the process of a worker or with real nodes."""

from __future__ import annotations

import functools
import hashlib
import json
import os
import platform
import socket
import time
import traceback
from pathlib import Path
from typing import Any, Sequence

import numpy as np

from sdc_common.configuration import package_folder
from sdc_experiments.closed_loop import drive_result
from sdc_experiments.sweep.results import FAILED
from sdc_experiments.sweep.settings import CONTROLLER, ROS, nested, text
from sdc_experiments.sweep.study import Cell
from sdc_experiments.sweep.true_metrics import true_metrics
from sdc_sim.report.writer import is_complete

_PACKAGES = ("sdc_common", "sdc_map", "sdc_sim", "sdc_package")
_CODE_ENDINGS = (".py", ".yaml", ".launch", ".csv")
_MODULES = (
    *("configuration.py", "closed_loop.py", "scenarios.py", "sweep/cell_drive.py"),
    *("championship/drive.py", "championship/league.py", "championship/score.py"),
)
# On a busy machine a node may need long for its answer, which must not change the drive.
_ROS_SETTINGS: dict[str, Any] = {
    "sim_options/start_patience_s": 120.0,
    "sim_options/patience_s": 20.0,
    "referee_options/pictures": False,
}
_OPTIONS = ("sim_options", "planner_options", "referee_options")
_SECTIONS = (*_OPTIONS, CONTROLLER)
_MAX_LOG = 200_000


@functools.lru_cache(maxsize=None)
def code_version() -> str:
    """Return a text that differs where code or libraries differ that decide about a drive."""
    found = hashlib.sha256(f"{platform.python_version()} {np.__version__}".encode())
    paths = [(name, Path(__file__).parents[1] / name) for name in _MODULES]
    leagues = "config/championship.yaml"
    paths.append((leagues, Path(package_folder("sdc_experiments"), leagues)))
    for package in _PACKAGES:
        root = Path(package_folder(package))
        # The share/ of an installed wheel is in its code.
        root = root.parent if root.name == "share" else root
        files = ((str(path.relative_to(root)), path) for path in sorted(root.rglob("*.*")))
        paths += [file for file in files if not file[0].startswith("test/")]
    for name, path in paths:
        if path.suffix in _CODE_ENDINGS:
            found.update(name.encode() + b"\0" + path.read_bytes())
    return found.hexdigest()


def worker_problem(version: str, paths: Sequence[str]) -> str:
    """Return why this process cannot drive cells, or "".

    These need the same `code_version`, and the files and folders that the drives read.
    """
    if code_version() != version:
        return "it has another version of the code or of its libraries; install the same there"
    missing = [path for path in paths if not os.path.exists(path)]
    if missing:
        return f"it has no {missing[0]}; put it into a folder that all workers share"
    return ""


def drive_cell(cell: Sequence, stack: str, timeout_s: float, version: str) -> tuple[dict, str]:
    """Drive one cell, with real nodes until a timeout of wall time.

    Returns:
        the row of the results, and the log of a drive that failed
    """
    driven = Cell(*cell)
    start = time.monotonic()
    row: dict[str, Any] = {"key": driven.key, **driven._asdict()}
    row.update(status=FAILED, worker=f"{socket.gethostname()}/{os.getpid()}", metrics={})
    log = worker_problem(version, ())
    try:
        if not log and stack == ROS:
            log = _drive_nodes(driven, timeout_s, row)
        elif not log:
            _drive_in_process(driven, row)
    except Exception:  # noqa: BLE001  a cell of any fault must not end the others
        log = traceback.format_exc()
    row["wall_s"] = round(time.monotonic() - start, 3)
    return row, log[-_MAX_LOG:]


def _drive_in_process(cell: Cell, row: dict[str, Any]) -> None:
    """Drive without ROS and complete the row."""
    settings = dict(cell.settings)
    options: dict[str, Any] = {name: nested(settings, name) for name in _OPTIONS}
    if "planned_speed_mps" in settings:
        options["planner_options"]["planned_speed_mps"] = float(settings["planned_speed_mps"])
    states: list = []
    result = drive_result(
        cell.scenario,
        route=settings.get("waypoints_path"),
        steering=settings.get("steering_method"),
        seed=cell.seed,
        controller_options=nested(settings, CONTROLLER),
        observe=lambda observation: states.append(observation.state),
        compiled=True,
        **options,
    )
    rows = np.ascontiguousarray(result.rows, dtype="<f8")
    row["metrics"] = {**result.metrics, **true_metrics(rows, states)}
    row["status"] = result.metrics["status"]
    row["trace_sha256"] = hashlib.sha256(rows.tobytes()).hexdigest()


def _drive_nodes(cell: Cell, timeout_s: float, row: dict[str, Any]) -> str:
    """Drive with real nodes and complete the row; return the log of a drive without a report."""
    settings: dict[str, Any] = {**_ROS_SETTINGS, **cell.settings, "sim_options/seed": cell.seed}
    values: dict[str, Any] = {}
    for name in (name.partition("/")[0] for name in settings):
        values[name] = nested(settings, name) if name in _SECTIONS else settings[name]
    parameters = {CONTROLLER: values.pop(CONTROLLER)} if CONTROLLER in values else {}
    texts = {name: text(value) for name, value in values.items()}
    from sdc_sim.runner import isolated_drive  # Only a drive with nodes needs ROS.

    with isolated_drive(cell.scenario, texts, parameters, timeout_s=timeout_s) as (drive, lines):
        report = Path(drive.report_path)
        if not report.exists() or not is_complete(drive.report_path):
            log = Path(drive.log_path).read_text(encoding="utf-8", errors="replace")
            return "\n".join([*lines[:-1], log])
        row["metrics"] = json.loads(report.read_text(encoding="utf-8"))
        row["status"] = row["metrics"]["status"]
        trace = report.with_suffix(".csv").read_bytes()
        row["trace_sha256"] = hashlib.sha256(trace).hexdigest()
    return ""
