"""sdc drive: the loop without ROS, with a status line, the report and its pages."""

from __future__ import annotations

import os
import sys
import time
from types import SimpleNamespace

from sdc_experiments.closed_loop import drive_result
from sdc_sim.report.console_progress import ConsoleProgress, closing_line
from sdc_sim.report.writer import companion, write_pages, write_report
from sdc_sim.scenario.acceptance_limits import read_report, violations
from sdc_sim.scenario.map_drive import given_points
from sdc_sim.scenario.packaged import find_scenario, parse_options
from sdc_sim.scenario.reader import load_scenario


def run(options: SimpleNamespace) -> int:
    """Drive, and return 0 if the route was completed, or the limits of the scenario are met.

    Raises:
        ValueError, OSError: the drive cannot start, or its report cannot be written
    """
    planner = parse_options(options.planner_options, "planner_options")
    if options.planned_speed_mps is not None:
        planner["planned_speed_mps"] = options.planned_speed_mps
    start, goals = (given_points(name, vars(options)) for name in ("start", "goal"))
    progress = ConsoleProgress(sys.stdout)
    result = drive_result(
        options.scenario,
        route=options.waypoints_path or None,
        map=options.map,
        start=start[0] if start else None,
        goal=goals or None,
        steering=options.steering_method or None,
        seed=options.seed,
        traffic=options.traffic,
        sim_options=parse_options(options.sim_options),
        planner_options=planner,
        referee_options=parse_options(options.referee_options, "referee_options"),
        watch=lambda evaluator: progress.update(evaluator, time.monotonic()),
    )
    report = os.path.expanduser(options.report)
    write_report(report, result)
    page = companion(report, ".html")
    try:
        write_pages(report, result)
    except ImportError as error:
        page = f"{report}, without pages ({error})"
    progress.print_line(f"{closing_line(result.metrics, 'drive')}; see {page}")
    if not options.scenario:
        return int(result.metrics["status"] != "completed")
    limits = load_scenario(find_scenario(options.scenario)).limits
    lines = violations(limits, *read_report(report))
    print(*(f"drive: {line}" for line in lines or ["all limits are met"]), sep="\n")
    return int(bool(lines))
