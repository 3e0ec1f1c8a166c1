"""Drive Snider's comparison again; write controllers.json, controllers.md and its pictures.

python3 -m sdc_experiments.snider [FOLDER]    FOLDER: the folder to write to, docs/ by default
"""

from __future__ import annotations

import os
import sys

import rospkg

from sdc_experiments.snider import plots, report
from sdc_experiments.snider.courses import figure_eight, lane_change, road_course
from sdc_experiments.snider.study import (
    NEUTRAL,
    UNDERSTEERING,
    all_drives,
    snider_car,
    understeering,
)


def docs_folder() -> str:
    """Return the folder docs/ of the project."""
    package = rospkg.RosPack().get_path("sdc_experiments")
    return os.path.normpath(os.path.join(package, "..", "..", "..", "docs"))


def main() -> None:
    """Run the command."""
    folder = sys.argv[1] if len(sys.argv) > 1 else docs_folder()
    if not os.path.isdir(folder):
        sys.exit(
            f"snider: there is no folder {folder}; "
            "name an existing one: python3 -m sdc_experiments.snider FOLDER"
        )
    car, _ = snider_car()
    courses = lane_change(), figure_eight(), road_course()
    traces = all_drives({NEUTRAL: car, UNDERSTEERING: understeering(car)}, courses)
    plots.draw(traces, courses, folder)
    stored = report.to_json(traces)
    with open(os.path.join(folder, "controllers.json"), "w", encoding="utf-8") as file:
        file.write(stored)
    path = os.path.join(folder, "controllers.md")
    with open(path, "w", encoding="utf-8") as file:
        file.write(report.page(report.from_json(stored)))
    print(f"snider: wrote {path}")


if __name__ == "__main__":
    main()
