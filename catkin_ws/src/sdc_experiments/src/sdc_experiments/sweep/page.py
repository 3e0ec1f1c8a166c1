"""The page of a study, one file that needs no other."""

from __future__ import annotations

import base64
import math
from pathlib import Path
from typing import Mapping, Sequence

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from sdc_experiments.sweep.heat_maps import draw, heat_maps, scenario_name, short_names
from sdc_experiments.sweep.results import FAILED
from sdc_experiments.sweep.settings import text
from sdc_experiments.sweep.statistics import CONFIDENCE, Combination, MeanEstimate, combinations
from sdc_experiments.sweep.study import Study

_TEMPLATES = Path(__file__).with_name("templates")
_TEMPLATE = "study.html.jinja"
# A longer table is in the CSV file.
_MAX_TABLE_ROWS = 2000
_MAX_FAILURES = 50
_LOG_LINES = 15


def write_page(folder: Path, study: Study, rows: Sequence[Mapping], missing: int) -> Path:
    """Write study.html, and each heat map as heat_map_METRIC.png, into a folder.

    Args:
        folder: the folder of the results
        study: the study
        rows: rows of the results in the order of the cells
        missing: number of cells that were not driven
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
    environment = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    names = short_names(list(study.factors))
    failures = [row for row in rows if row["status"] == FAILED]
    page = environment.get_template(_TEMPLATE).render(
        name=Path(study.path).stem,
        about=study.about,
        stack=study.stack,
        settings=[(name, text(value)) for name, value in study.settings.items()],
        counts={
            "drives": len(rows) - len(failures),
            "completed": sum(row["status"] == "completed" for row in rows),
            "failed": len(failures),
            "not driven": missing,
            "combinations": len(found),
            "seeds": len(study.seeds),
        },
        pictures=pictures,
        headings=["scenario", *names.values(), "completed", *study.metrics],
        percent=round(100.0 * CONFIDENCE),
        table=[_table_row(one) for one in found[:_MAX_TABLE_ROWS]],
        left_out=len(found[_MAX_TABLE_ROWS:]),
        failures=[_failure(folder, row) for row in failures[:_MAX_FAILURES]],
        more_failures=len(failures[_MAX_FAILURES:]),
    )
    path = folder / "study.html"
    path.write_text(page, encoding="utf-8")
    return path


def _table_row(one: Combination) -> list[str]:
    failed = f", {one.failed} failed" if one.failed else ""
    return [
        scenario_name(one.scenario),
        *map(text, one.values.values()),
        f"{one.completed} of {one.drives}{failed}",
        *map(_estimate, one.metrics.values()),
    ]


def _estimate(found: MeanEstimate) -> str:
    """Return a mean and half of its confidence interval, with the same number of decimals."""
    if math.isnan(found.mean):
        return "–"
    if math.isnan(found.half_width):
        return f"{found.mean:.4g}"
    if found.half_width == 0.0:
        return f"{found.mean:.4g} ± 0"
    decimals = max(0, 1 - math.floor(math.log10(found.half_width)))
    return f"{found.mean:.{decimals}f} ± {found.half_width:.{decimals}f}"


def _failure(folder: Path, row: Mapping) -> dict[str, str]:
    log = ""
    path = folder / row.get("log", "")
    if path.is_file():
        log = "\n".join(
            path.read_text(encoding="utf-8", errors="replace").splitlines()[-_LOG_LINES:]
        )
    settings = ", ".join(f"{name} {text(value)}" for name, value in row["settings"].items())
    return {
        "cell": f"{scenario_name(row['scenario'])}, {settings}, seed {row['seed']}",
        "log": log,
        "path": row.get("log", ""),
    }
