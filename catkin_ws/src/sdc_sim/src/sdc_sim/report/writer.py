"""The files of a report: metrics, the trace of every tick, and pages for people."""

from __future__ import annotations

import contextlib
import csv
import json
import math
import os
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from sdc_sim.evaluation.drive_evaluation import COLUMNS, DriveEvaluation
from sdc_sim.evaluation.evaluator import evaluate_events
from sdc_sim.evaluation.event_file import EventFile, read_events

EVENTS = ".events.jsonl"
PARAMETERS = ".parameters.json"
_PAGES = (".png", ".html")
# Parameters of the world that name what is driven; the first one that is not empty does.
_WAYS = ("street_scenario", "obstacles_path", "map_path", "waypoints_path")


class ReportError(OSError):
    """The report cannot be written; the message names the file and the fix."""


def companion(report_path: str, extension: str) -> str:
    """Return the path of the report with another extension, such as ".csv"."""
    return os.path.splitext(report_path)[0] + extension


@contextlib.contextmanager
def _failing_with(
    report_path: str, advice: str, errors: tuple[type[Exception], ...] = (OSError,)
) -> Iterator[None]:
    """Raise an error of the block as a ReportError with its file and advice."""
    try:
        yield
    except errors as error:
        path = getattr(error, "filename", None) or report_path
        reason = getattr(error, "strerror", None) or error
        raise ReportError(f"{path}: {reason}; {advice}") from error


def open_report(
    report_path: str, on_failure: Callable[[OSError], None] = lambda error: None
) -> EventFile:
    """Make the report's folder, remove an older report, and start the file of events.

    Args:
        report_path: path of report.json, as in all functions below
        on_failure: called once, when an event cannot be written

    Raises:
        ReportError: the folder or the file cannot be written
    """
    with _failing_with(report_path, "name a file in a writable folder with report:=FILE"):
        os.makedirs(os.path.dirname(report_path) or ".", exist_ok=True)
        others = (companion(report_path, suffix) for suffix in (".csv", PARAMETERS, *_PAGES))
        for path in (report_path, *others):
            with contextlib.suppress(FileNotFoundError):
                os.remove(path)
        return EventFile(companion(report_path, EVENTS), on_failure)


def is_complete(report_path: str) -> bool:
    """Return whether a report does not lack what the events of its drive can add."""
    return not os.path.exists(companion(report_path, EVENTS))


def complete_report(report_path: str) -> None:
    """Write what is missing of the report of a drive whose referee was killed.

    Raises:
        ReportError: there are no events of the drive, or a file cannot be written
    """
    path = companion(report_path, EVENTS)
    with _failing_with(path, "drive again", (OSError, ValueError)):
        result = evaluate_events(read_events(path))
    write_report(report_path, result)
    write_pages(report_path, result)
    os.remove(path)


def write_report(report_path: str, result: DriveEvaluation) -> None:
    """Write the trace of an evaluated drive and then, atomically, the metrics.

    Raises:
        ReportError: a file cannot be written
    """
    with _failing_with(report_path, "the drive is not reported"):
        os.makedirs(os.path.dirname(report_path) or ".", exist_ok=True)
        write_trace(companion(report_path, ".csv"), result)
        write_json(report_path, result.metrics, indent=2)


def write_trace(path: str, result: DriveEvaluation) -> None:
    """Write one row for each odometry, with all digits, and the command that answered it.

    An unknown command or reason is empty.
    """
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow((*COLUMNS, "reason"))
        for row, reason in zip(result.rows.tolist(), result.reasons):
            writer.writerow([*("" if math.isnan(value) else value for value in row), reason])


@contextlib.contextmanager
def complete(path: str | Path, mode: int = 0o644) -> Iterator[Path]:
    """Yield the path of a file that takes the place of `path` when it is written."""
    part = Path(f"{path}.part")
    try:
        part.touch(mode)
        yield part
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def write_json(path: str | Path, content: Mapping, mode: int = 0o644, indent: int = 1) -> None:
    """Write a file of JSON that is complete or not there."""
    with complete(path, mode) as part:
        part.write_text(json.dumps(content, indent=indent) + "\n", encoding="utf-8")


def write_pages(report_path: str, result: DriveEvaluation) -> None:
    """Write report.png and report.html of a drive with its whole trace, each atomically.

    Raises:
        ReportError: a file cannot be written
    """
    # Matplotlib is slow to import, and only the end of a drive needs it.
    from sdc_sim.report.html_page import write_html
    from sdc_sim.report.plots import write_png

    with _failing_with(report_path, "the metrics are written, the pages are not"):
        with complete(companion(report_path, ".png")) as path:
            write_png(str(path), result)
        with complete(companion(report_path, ".html")) as path:
            write_html(str(path), result, title_of(report_path))


def title_of(report_path: str) -> str:
    """Return the scenario, the map or the route of a drive, its steering method and its date.

    They are those of the parameters that the referee wrote; "" for a drive without ROS.
    """
    path = companion(report_path, PARAMETERS)
    try:
        with open(path, encoding="utf-8") as file:
            parameters = json.load(file)
        date = time.strftime("%Y-%m-%d %H:%M", time.localtime(os.path.getmtime(path)))
    except (OSError, ValueError):
        return ""
    sim, car = (parameters.get(name) or {} for name in ("sim", "simple_controller"))
    ways = (sim.get(name) for name in _WAYS)
    way = next((os.path.splitext(os.path.basename(way))[0] for way in ways if way), "")
    return ", ".join(filter(None, (way, car.get("steering_method"), date)))
