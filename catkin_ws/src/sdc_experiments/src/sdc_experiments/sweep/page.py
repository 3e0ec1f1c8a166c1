"""The page of a study, one file that needs no other."""

from __future__ import annotations

import base64
import math
from pathlib import Path
from typing import Mapping, Sequence

from sdc_experiments.sweep.heat_maps import draw, heat_maps, scenario_name, short_names
from sdc_experiments.sweep.settings import text
from sdc_experiments.sweep.statistics import CONFIDENCE, MeanEstimate, combinations
from sdc_experiments.sweep.study import Study
from sdc_sim.report import templates

_LOG_LINES = 15


def write_page(folder: Path, study: Study, rows: Sequence[Mapping], missing: int) -> Path:
    """Write study.html, and each heat map as heat_map_METRIC.png, into the folder of the results.

    The rows are in the order of the cells, and some may be missing.
    """
    found = combinations(rows, study.factors, study.metrics)
    pictures = []
    for metric in study.metrics:
        maps = heat_maps(found, metric)
        if maps is not None:
            path = folder / f"heat_map_{metric}.png"
            draw(maps, path)
            encoded = base64.b64encode(path.read_bytes()).decode()
            pictures.append((metric, encoded, maps.left_out))

    def log(row: Mapping) -> str:
        lines = (folder / row["log"]).read_text(encoding="utf-8", errors="replace").splitlines()
        return "\n".join(lines[-_LOG_LINES:])

    own = Path(__file__).with_name("templates")
    environment = templates(own, trim_blocks=True, lstrip_blocks=True)
    for function in (text, log, estimate_text, scenario_name):
        environment.filters[function.__name__] = function
    shown = {"study": study, "rows": rows, "found": found, "missing": missing}
    names, percent = short_names(list(study.factors)).values(), round(100.0 * CONFIDENCE)
    template = environment.get_template("study.html.jinja")
    page = template.render(**shown, pictures=pictures, names=names, percent=percent)
    path = folder / "study.html"
    path.write_text(page, encoding="utf-8")
    return path


def estimate_text(found: MeanEstimate) -> str:
    """Return a mean and half of its confidence interval, with the same number of decimals."""
    if math.isnan(found.mean):
        return "–"
    if math.isnan(found.half_width):
        return f"{found.mean:.4g}"
    if found.half_width == 0.0:
        return f"{found.mean:.4g} ± 0"
    decimals = max(0, 1 - math.floor(math.log10(found.half_width)))
    return f"{found.mean:.{decimals}f} ± {found.half_width:.{decimals}f}"
