"""The files of a report: metrics, the trace of every tick, and pages for people."""

from __future__ import annotations

import contextlib
import csv
import json
import math
import os
from collections.abc import Callable, Iterator

from sdc_sim.evaluation.drive_evaluation import COLUMNS, DriveResult
from sdc_sim.evaluation.evaluator import evaluate_events
from sdc_sim.evaluation.event_file import EventFile, read_events

EVENTS = ".events.jsonl"
_PAGES = (".png", ".html")


class ReportError(OSError):
    """The report cannot be written; the message names the file and the fix."""


def companion(report_path: str, extension: str) -> str:
    """Return the path of the report with another extension, such as ".csv"."""
    return os.path.splitext(report_path)[0] + extension


def open_report(
    report_path: str, on_failure: Callable[[OSError], None] = lambda error: None
) -> EventFile:
    """Make the report's folder, remove an older report, and start the file of events.

    Args:
        report_path: path of report.json
        on_failure: called once, when an event cannot be written

    Raises:
        ReportError: the folder or the file cannot be written
    """
    try:
        os.makedirs(os.path.dirname(report_path) or ".", exist_ok=True)
        for path in (report_path, *(companion(report_path, one) for one in (".csv", *_PAGES))):
            with contextlib.suppress(FileNotFoundError):
                os.remove(path)
        return EventFile(companion(report_path, EVENTS), on_failure)
    except OSError as error:
        raise ReportError(
            f"{error.filename or report_path}: {error.strerror}; "
            "name a file in a writable folder with report:=FILE"
        ) from error


def is_complete(report_path: str) -> bool:
    """Return whether a report does not lack what the events of its drive can add."""
    return not os.path.exists(companion(report_path, EVENTS))


def complete_report(report_path: str) -> None:
    """Write what is missing of the report of a drive whose referee was killed.

    Args:
        report_path: path of report.json

    Raises:
        ReportError: there are no events of the drive, or a file cannot be written
    """
    path = companion(report_path, EVENTS)
    try:
        result = evaluate_events(read_events(path))
    except OSError as error:
        raise ReportError(f"{path}: {error.strerror}; drive again") from error
    except ValueError as error:
        raise ReportError(f"{path}: {error}; drive again") from error
    write_report(report_path, result)
    write_pages(report_path, result)
    os.remove(path)


def write_report(report_path: str, result: DriveResult) -> None:
    """Write the trace and then, atomically, the metrics.

    Args:
        report_path: path of report.json
        result: the evaluated drive

    Raises:
        ReportError: a file cannot be written
    """
    try:
        os.makedirs(os.path.dirname(report_path) or ".", exist_ok=True)
        write_trace(companion(report_path, ".csv"), result)
        with _complete(report_path) as path, open(path, "w", encoding="utf-8") as file:
            json.dump(result.metrics, file, indent=2)
            file.write("\n")
    except OSError as error:
        raise ReportError(
            f"{error.filename or report_path}: {error.strerror}; the drive is not reported"
        ) from error


def write_trace(path: str, result: DriveResult) -> None:
    """Write one row for each odometry, with all digits, and the command that answered it.

    An unknown command or reason is empty.
    """
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow((*COLUMNS, "reason"))
        for row, reason in zip(result.rows.tolist(), result.reasons):
            writer.writerow([*("" if math.isnan(value) else value for value in row), reason])


@contextlib.contextmanager
def _complete(path: str) -> Iterator[str]:
    """Yield the path of a file that takes the place of `path` when it is written."""
    part = path + ".part"
    try:
        yield part
        os.replace(part, path)
    finally:
        with contextlib.suppress(OSError):
            os.remove(part)


def write_pages(report_path: str, result: DriveResult) -> None:
    """Write report.png and report.html, each atomically.

    Args:
        report_path: path of report.json
        result: the evaluated drive, with its whole trace

    Raises:
        ReportError: a file cannot be written
    """
    # Matplotlib is slow to import, and only the end of a drive needs it.
    from sdc_sim.report.html_page import write_html
    from sdc_sim.report.plots import write_png

    try:
        with _complete(companion(report_path, ".png")) as path:
            write_png(path, result)
        with _complete(companion(report_path, ".html")) as path:
            write_html(path, result)
    except OSError as error:
        raise ReportError(
            f"{error.filename or report_path}: {error.strerror}; "
            "the metrics are written, the pages are not"
        ) from error
