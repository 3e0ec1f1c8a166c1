"""Heat maps of a study: the mean of a metric over two factors."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any, NamedTuple, Sequence

import numpy as np

from sdc_experiments.sweep.settings import text
from sdc_experiments.sweep.statistics import Combination

SCENARIO = "scenario"
MAX_PANELS = 12
_PANELS_IN_A_ROW = 3
_DARK = 0.45
# Metrics of which more is better; of all others, less is.
_MORE_IS_BETTER = ("driving_score", "route_completion_percent", "speed_mean_mps")


class Panel(NamedTuple):
    """A heat map."""

    title: str  # the values of the other factors
    means: np.ndarray  # (rows, columns) mean of the metric, NaN without a value
    labels: list[list[str]]  # text of each cell


class HeatMaps(NamedTuple):
    """The heat maps of one metric, of which all have the same axes."""

    metric: str  # the metric
    x: tuple[str, list]  # name and values of the factor along the columns
    y: tuple[str, list]  # the same along the rows
    panels: list[Panel]  # one heat map for each combination of the other factors
    left_out: int  # number of panels that are too many for a page


def short_names(names: Sequence[str]) -> dict[str, str]:
    """Return the last two parts of each name, or the whole name where these are not unique."""
    last = ["/".join(name.split("/")[-2:]) for name in names]
    return {name: short if last.count(short) == 1 else name for name, short in zip(names, last)}


def scenario_name(scenario: str) -> str:
    """Return the name of a scenario without folder and ending."""
    return Path(scenario).stem


def heat_maps(found: Sequence[Combination], metric: str) -> HeatMaps | None:
    """Return the heat maps of a metric over the first two factors with more than one value.

    Returns:
        None where fewer than two factors vary
    """
    table = [{**result.values, SCENARIO: scenario_name(result.scenario)} for result in found]
    values = {
        name: list({text(row[name]): row[name] for row in table}.values()) for name in table[0]
    }
    varied = [name for name, options in values.items() if len(options) > 1]
    if len(varied) < 2:
        return None
    y, x, *others = varied
    names = short_names(varied)
    panels = []
    for options in itertools.product(*(values[name] for name in others)):
        fixed = dict(zip(others, options))
        means = np.full((len(values[y]), len(values[x])), math.nan)
        labels = [["" for _ in values[x]] for _ in values[y]]
        for row, result in zip(table, found):
            if all(row[name] == value for name, value in fixed.items()):
                i, j = values[y].index(row[y]), values[x].index(row[x])
                means[i, j] = result.metrics[metric].mean
                labels[i][j] = _label(result, metric)
        title = ", ".join(f"{names[name]} {text(value)}" for name, value in fixed.items())
        panels.append(Panel(title, means, labels))
    axes = (names[x], values[x]), (names[y], values[y])
    return HeatMaps(metric, *axes, panels[:MAX_PANELS], len(panels[MAX_PANELS:]))


def _label(result: Combination, metric: str) -> str:
    mean = result.metrics[metric].mean
    lines = [] if math.isnan(mean) else [f"{mean:.3g}"]
    if result.failed:
        lines.append(f"{result.failed} failed")
    if result.completed < result.drives:
        lines.append(f"{100.0 * result.completed / result.drives:.0f} % completed")
    return "\n".join(lines)


def draw(maps: HeatMaps, path: Path) -> None:
    """Write the heat maps of a metric into a PNG file. Blue is better."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # slow to import
    from matplotlib.colors import LogNorm, Normalize
    from matplotlib.figure import Figure

    columns = min(_PANELS_IN_A_ROW, len(maps.panels))
    rows = math.ceil(len(maps.panels) / columns)
    width = max(3.6, 0.85 * len(maps.x[1]) + 1.2)
    height = max(2.2, 0.42 * len(maps.y[1]) + 1.1)
    figure = Figure(figsize=(columns * width + 1.0, rows * height + 0.5), layout="constrained")
    FigureCanvasAgg(figure)
    all_means = np.concatenate([panel.means.ravel() for panel in maps.panels])
    known = all_means[np.isfinite(all_means)]
    low, high = (known.min(), known.max()) if len(known) else (0.0, 1.0)
    is_wide = low > 0.0 and high > 10.0 * low
    norm = LogNorm(low, high) if is_wide else Normalize(low, high if high > low else low + 1.0)
    colours = "RdYlBu" if maps.metric in _MORE_IS_BETTER else "RdYlBu_r"
    axes: Any = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    image: Any = None
    for place, panel in itertools.zip_longest(axes.ravel(), maps.panels):
        if panel is None:
            place.set_axis_off()
            continue
        image = place.imshow(panel.means, cmap=colours, norm=norm, aspect="auto", origin="lower")
        place.set_facecolor("#d0d0d0")
        place.set_title(panel.title, fontsize=10)
        for i, j in itertools.product(range(len(maps.y[1])), range(len(maps.x[1]))):
            red, green, blue, _ = image.to_rgba(panel.means[i, j])
            dark = 0.3 * red + 0.6 * green + 0.1 * blue < _DARK and np.isfinite(panel.means[i, j])
            colour = "white" if dark else "black"
            place.text(j, i, panel.labels[i][j], ha="center", va="center", fontsize=8, color=colour)
    for place in axes.ravel():
        place.set_xticks(range(len(maps.x[1])), [text(value) for value in maps.x[1]])
        place.set_yticks(range(len(maps.y[1])), [text(value) for value in maps.y[1]])
    figure.supxlabel(maps.x[0], fontsize="medium")
    figure.supylabel(maps.y[0], fontsize="medium")
    figure.colorbar(image, ax=axes, label=maps.metric)
    figure.savefig(path, dpi=110, facecolor="white")
