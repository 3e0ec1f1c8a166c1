#!/usr/bin/env python3
"""Write what is missing of a report: after a kill the metrics, the trace and the pages.

Usage: rosrun sdc_sim report.py FOLDER
"""

import argparse
import os
import sys

from sdc_sim.report.writer import ReportError, complete_report, is_complete


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("report", metavar="FOLDER", help="folder of report.json, or its path")
    path = parser.parse_args().report
    if not path.endswith(".json"):
        path = os.path.join(path, "report.json")
    if is_complete(path) and os.path.exists(path):
        print(f"{path}: nothing is missing")
        return
    try:
        complete_report(path)
    except ReportError as error:
        sys.exit(f"report: {error}")
    print(f"{path}: completed from the events of its drive")


if __name__ == "__main__":
    main()
