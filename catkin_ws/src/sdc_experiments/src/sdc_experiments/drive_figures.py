"""Measure how well the car drives, and write the figures to README.md and docs/drive.md.

python3 -m sdc_experiments.drive_figures [PROJECT]    PROJECT: the folder of README.md

Each row of the table is a drive in lockstep; the closing line is that of a drive in real time, so
the command takes some minutes. The measured metrics are stored in docs/drive.json.
"""

from __future__ import annotations

import json
import re
import shlex
import sys
from pathlib import Path
from typing import Any, Iterable

import rospkg

from sdc_experiments.stack_launch import drive_stack
from sdc_sim.report.console_progress import closing_line

STORED = "docs/drive.json"
PAGES = ("README.md", "docs/drive.md")
# The rows of the table, as a user types them.
COMMANDS = (
    "./drive",
    './drive planned_speed_mps:=25 planner_options:="{lateral_acceleration_mps2: 6.0}"',
    './drive sim_options:="{friction: 0.6, command_latency_s: 0.1, odometry_noise: '
    '{position_m: 0.05, heading_rad: 0.0, speed_mps: 0.0}}"',
)
_HEADER = """| command | cross-track error, RMS | at worst | duration / least possible |
|---|---|---|---|
"""
_METRICS = (
    "status",
    "route_completion_percent",
    "route_length_m",
    "duration_s",
    "real_time_factor",
    "cross_track_rms_m",
    "cross_track_max_m",
    "driving_score",
    "time_ratio",
    "comfortable",
)
_CLOSING_LINE = re.compile(r"^    referee: completed: .*$", re.MULTILINE)
_TABLE = re.compile(re.escape(_HEADER) + r"(\|.*\n)*")


def measure(commands: Iterable[str] = COMMANDS) -> dict[str, Any]:
    """Return the metrics of a drive in real time, and of each command in lockstep.

    Raises:
        RuntimeError: a drive wrote no report, or was not completed
    """
    lockstep = {
        command: _metrics(["sync:=true", "camera:=false", *shlex.split(command)[1:]])
        for command in commands
    }
    return {"real_time": _metrics([]), "lockstep": lockstep}


def _metrics(arguments: list[str]) -> dict[str, Any]:
    report = drive_stack(arguments)
    if report["status"] != "completed":
        raise RuntimeError(f"the drive with {arguments} ended with: {report['status']}")
    return {name: report[name] for name in _METRICS}


def with_figures(page: str, stored: dict[str, Any]) -> str:
    """Return the text of a page with the stored figures in its closing line and its table."""
    line = f"    {closing_line(stored['real_time'])}; see report/report.json"
    rows = [
        f"| `{command}` | {one['cross_track_rms_m']:.3f} m | {one['cross_track_max_m']:.3f} m "
        f"| {one['time_ratio']:.3f} |\n"
        for command, one in stored["lockstep"].items()
    ]
    return _TABLE.sub(lambda _: _HEADER + "".join(rows), _CLOSING_LINE.sub(lambda _: line, page))


def main() -> None:
    """Run the command."""
    package = Path(rospkg.RosPack().get_path("sdc_experiments"))
    project = Path(sys.argv[1]) if len(sys.argv) > 1 else package.parents[2]
    missing = [name for name in PAGES if not (project / name).is_file()]
    if missing:
        sys.exit(
            f"drive_figures: {project} has no {missing[0]}; name the folder of the project: "
            "python3 -m sdc_experiments.drive_figures PROJECT"
        )
    stored = measure()
    (project / STORED).write_text(json.dumps(stored, indent=1) + "\n", encoding="utf-8")
    for name in PAGES:
        path = project / name
        text = path.read_text(encoding="utf-8")
        path.write_text(with_figures(text, stored), encoding="utf-8")
        print(f"drive_figures: wrote {path}")


if __name__ == "__main__":
    main()
