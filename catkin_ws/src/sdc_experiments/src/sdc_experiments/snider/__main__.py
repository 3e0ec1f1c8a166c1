"""Drive Snider's comparison again; write controllers.json, its picture and the page's tables.

python3 -m sdc_experiments.snider [FOLDER]    FOLDER: where to write, docs/ by default
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Sequence

from sdc_common.configuration import package_folder
from sdc_experiments.snider import page, study
from sdc_experiments.snider.courses import figure_eight, lane_change, road_course


def main(arguments: Sequence[str]) -> None:
    """Run the command."""
    docs = Path(package_folder("sdc_experiments")).parents[2] / "docs"
    folder = Path(arguments[0]) if arguments else docs
    if not folder.is_dir():
        sys.exit(f"snider: there is no folder {folder}; name an existing one")
    car, _ = study.snider_car()
    courses = lane_change(), figure_eight(), road_course()
    cars = {study.NEUTRAL: car, study.UNDERSTEERING: study.understeering(car)}
    peaks = study.all_drives(cars, courses)
    page.draw(peaks, str(folder / "controllers_speed.png"))
    stored = page.to_json(peaks)
    (folder / "controllers.json").write_text(stored, encoding="utf-8")
    text = (docs / "controllers.md").read_text(encoding="utf-8")
    text = page.updated(text, peaks)
    (folder / "controllers.md").write_text(text, encoding="utf-8")
    print(f"snider: wrote {folder / 'controllers.md'}; its text has figures, too: read it again")


if __name__ == "__main__":
    main(sys.argv[1:])
