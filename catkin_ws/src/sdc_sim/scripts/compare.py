#!/usr/bin/env python3
"""Two reports side by side: rosrun sdc_sim compare.py A B [--plot FILE.png]; A and B are report.json files or their folders."""

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
        help="where both drives are drawn; default: %(default)s",
    )
    arguments = parser.parse_args()
    try:
        a, b = load_report(arguments.a), load_report(arguments.b)
    except ReportReadError as error:
        print(f"compare: {error}", file=sys.stderr)
        return 1
    print(f"A: {a.name}\nB: {b.name}\n\n{as_table(differences(a.figures, b.figures))}\n")
    if a.trace is None or b.trace is None:
        print("no picture: the trace (.csv) beside a report is missing")
        return 0
    try:
        draw_overlay(arguments.plot, a, b)
    except (OSError, ValueError) as error:
        print(
            f"compare: {arguments.plot}: {getattr(error, 'strerror', None) or error}; name another file with --plot",
            file=sys.stderr,
        )
        return 1
    print(f"both drives: {arguments.plot}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
