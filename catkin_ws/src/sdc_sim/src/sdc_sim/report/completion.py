"""Write the parts of a report that are missing, from the event log of its drive.

Usage: python3 -m sdc_sim.report.completion REPORT.json
"""

from __future__ import annotations

import json
import os
import subprocess
import sys

from sdc_sim.evaluation.evaluator import evaluate_event_log
from sdc_sim.evaluation.event_log import EventLog
from sdc_sim.report.trace_file import TraceFile
from sdc_sim.report.writer import (
    EVENT_LOG,
    ReportError,
    companion,
    remove_pages,
    write_pages,
    write_report,
)


def start_completion(report_path: str) -> None:
    """Complete a report in a process of its own, which outlives the launch.

    Roslaunch kills the processes of a node some seconds after it has asked the node to end. On a
    busy machine the pages take longer.
    """
    environment = {name: value for name, value in os.environ.items() if name != "ROS_MASTER_URI"}
    subprocess.Popen(
        [sys.executable, "-m", __name__, report_path],
        env=environment,  # it belongs to no master: it only reads and writes files
        stdin=subprocess.DEVNULL,
        start_new_session=True,
    )


def complete_report(report_path: str) -> bool:
    """Write the pages of a report, and before them the metrics and the trace if they are missing.

    Another process that writes them, or a drive that lasts, is waited for.

    Args:
        report_path: path of report.json

    Returns:
        whether this call wrote something

    Raises:
        ReportError: there is no event log, or a file cannot be written
    """
    path = companion(report_path, EVENT_LOG)
    try:
        event_log = EventLog.unfinished(path)
        if event_log is None:
            return False
        result = evaluate_event_log(event_log)
    except OSError as error:
        raise ReportError(f"{path}: {error.strerror}; drive again") from error
    except ValueError as error:
        raise ReportError(f"{path}: {error}; drive again") from error
    try:
        with open(report_path, encoding="utf-8") as file:
            result.metrics = json.load(file)
    except (OSError, ValueError):
        write_report(report_path, result)
        TraceFile(companion(report_path, ".csv")).remove()
    write_pages(report_path, result)
    if event_log.is_replaced:  # The next drive into this folder has removed the report.
        remove_pages(report_path)
    event_log.remove()
    return True


def is_complete(report_path: str) -> bool:
    """Return whether no event log is left of the drive."""
    return not os.path.exists(companion(report_path, EVENT_LOG))


def main() -> int:
    """Complete a report; return the exit status."""
    try:
        complete_report(sys.argv[1])
    except ReportError as error:
        print(f"report: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
