"""Writes what a drive measured: report.json, a trace of every tick, and the pages that a person looks at."""

from __future__ import annotations

import contextlib
import csv
import json
import math
import os

from sdc_sim.evaluation.evaluator import DriveResult
from sdc_sim.evaluation.event_log import EventLog
from sdc_sim.evaluation.route_progress import DriveSample

COMMAND_FIELDS = ("throttle", "brake", "steer")
_JOURNAL = ".journal"
_COMPANIONS = (".csv", ".png", ".html", _JOURNAL)


class ReportError(OSError):
    """The report cannot be written; the message names the file and the mend."""


def companion(report_path: str, ending: str) -> str:
    """The file beside the report with another ending, such as ".csv"."""
    return os.path.splitext(report_path)[0] + ending


def open_report(report_path: str, drive_id: str) -> EventLog:
    """Make the report's folder and the journal of this drive. A journal of it that is there already is gone on with; an older
    report is removed, so that none is taken for the new one. Raises ReportError."""
    try:
        os.makedirs(os.path.dirname(report_path) or ".", exist_ok=True)
        journal = EventLog(companion(report_path, _JOURNAL), drive_id)
        for path in (
            report_path,
            *(companion(report_path, ending) for ending in _COMPANIONS if ending != _JOURNAL),
        ):
            with contextlib.suppress(FileNotFoundError):
                os.remove(path)
        if journal.failure is not None:
            raise journal.failure
    except OSError as error:
        raise ReportError(
            f"{error.filename or report_path}: {error.strerror}; name a file in a folder that can be written to "
            "with report:=FILE"
        ) from error
    return journal


def write_report(report_path: str, result: DriveResult) -> None:
    """Write a CSV of every sample and then, at once and whole, the figures as JSON. Raises ReportError."""
    try:
        os.makedirs(os.path.dirname(report_path) or ".", exist_ok=True)
        write_trace(companion(report_path, ".csv"), result)
        with open(report_path + ".part", "w", encoding="utf-8") as file:
            json.dump(result.figures, file, indent=2)
            file.write("\n")
        os.replace(report_path + ".part", report_path)
    except OSError as error:
        raise ReportError(
            f"{error.filename or report_path}: {error.strerror}; the drive was not reported"
        ) from error


def write_trace(path: str, result: DriveResult) -> None:
    """One row a sample, with every digit, and the command that answered it: two traces are equal when the drives were."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(DriveSample._fields + COMMAND_FIELDS)
        for sample, command in zip(result.drive.samples, result.commands.tolist()):
            writer.writerow((*sample, *("" if math.isnan(value) else value for value in command)))


def write_pages(report_path: str, result: DriveResult, snapshots) -> None:
    """Draw report.png and report.html. Raises ReportError."""
    from sdc_sim.report.html_page import (  # Matplotlib is slow to load, and needed once, at the end of a drive
        write_html,
        write_png,
    )

    try:
        write_png(companion(report_path, ".png"), result)
        write_html(companion(report_path, ".html"), result, snapshots)
    except OSError as error:
        raise ReportError(
            f"{error.filename or report_path}: {error.strerror}; the figures are written, the pages are not"
        ) from error
