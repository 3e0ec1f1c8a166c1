"""The files of a report: metrics, the trace of every tick, and pages for people."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterator

from sdc_sim.evaluation.drive_evaluation import DriveResult
from sdc_sim.evaluation.event_log import EventLog
from sdc_sim.report.trace_file import TraceFile, write_rows

EVENT_LOG = ".journal"


class ReportError(OSError):
    """The report cannot be written; the message names the file and the fix."""


def companion(report_path: str, extension: str) -> str:
    """Return the path of the report with another extension, such as ".csv"."""
    return os.path.splitext(report_path)[0] + extension


def open_report(report_path: str, drive_id: str) -> EventLog:
    """Make the report's folder, remove an older report and open the event log, locked.

    Args:
        report_path: path of report.json
        drive_id: identifies the drive; an event log of this drive is resumed

    Raises:
        ReportError: the folder or the event log cannot be written
    """
    try:
        os.makedirs(os.path.dirname(report_path) or ".", exist_ok=True)
        event_log = EventLog.locked(companion(report_path, EVENT_LOG), drive_id)
        for path in (report_path, companion(report_path, ".csv")):
            with contextlib.suppress(FileNotFoundError):
                os.remove(path)
        remove_pages(report_path)
    except OSError as error:
        raise ReportError(
            f"{error.filename or report_path}: {error.strerror}; "
            "name a file in a writable folder with report:=FILE"
        ) from error
    return event_log


def write_report(report_path: str, result: DriveResult, trace: TraceFile | None = None) -> None:
    """Write the trace and then, atomically, the metrics.

    Args:
        report_path: path of report.json
        result: the evaluated drive
        trace: has the rows that the result does not have

    Raises:
        ReportError: a file cannot be written
    """
    try:
        os.makedirs(os.path.dirname(report_path) or ".", exist_ok=True)
        if trace is not None and trace.failure is None:
            trace.finish(result.rows, result.reasons)
        else:
            if trace is not None:
                trace.remove()
            write_trace(companion(report_path, ".csv"), result)
        with _complete(report_path) as path, open(path, "w", encoding="utf-8") as file:
            json.dump(result.metrics, file, indent=2)
            file.write("\n")
    except OSError as error:
        raise ReportError(
            f"{error.filename or report_path}: {error.strerror}; the drive is not reported"
        ) from error


def write_trace(path: str, result: DriveResult) -> None:
    """Write one row for each sample, with all digits, and the command that answered it."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        write_rows(file, result.rows.tolist(), result.reasons)


def remove_pages(report_path: str) -> None:
    """Remove report.png and report.html, where they exist.

    Raises:
        OSError: a file cannot be removed
    """
    for extension in (".png", ".html"):
        with contextlib.suppress(FileNotFoundError):
            os.remove(companion(report_path, extension))


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
    from sdc_sim.report.camera_snapshots import CameraSnapshot
    from sdc_sim.report.html_page import write_html
    from sdc_sim.report.plots import write_png

    try:
        with _complete(companion(report_path, ".png")) as path:
            write_png(path, result)
        snapshots = [CameraSnapshot(*snapshot) for snapshot in result.snapshots]
        with _complete(companion(report_path, ".html")) as path:
            write_html(path, result, snapshots)
    except OSError as error:
        raise ReportError(
            f"{error.filename or report_path}: {error.strerror}; "
            "the metrics are written, the pages are not"
        ) from error
