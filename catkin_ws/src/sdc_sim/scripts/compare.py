#!/usr/bin/env python3
"""Compare two reports, each named by its report.json or its folder.

Usage: rosrun sdc_sim compare.py A B [--plot FILE.png]
"""

import argparse
import sys

from sdc_sim.report.comparison import (
    ReportReadError,
    as_table,
    differences,
    draw_overlay,
    load_report,
)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("a", metavar="A")
    parser.add_argument("b", metavar="B")
    parser.add_argument(
        "--plot",
        metavar="FILE.png",
        default="compare.png",
        help="image of both drives; default: %(default)s",
    )
    arguments = parser.parse_args()
    try:
        a, b = load_report(arguments.a), load_report(arguments.b)
    except ReportReadError as error:
        sys.exit(f"compare: {error}")
    print(f"A: {a.name}\nB: {b.name}\n\n{as_table(differences(a.metrics, b.metrics))}\n")
    if a.trace is None or b.trace is None:
        print("no picture: a report has no trace (.csv) in its folder")
        return
    try:
        draw_overlay(arguments.plot, a, b)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        sys.exit(f"compare: {arguments.plot}: {reason}; name another file with --plot")
    print(f"both drives: {arguments.plot}")


if __name__ == "__main__":
    main()
