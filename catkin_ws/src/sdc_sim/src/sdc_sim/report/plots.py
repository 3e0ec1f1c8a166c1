"""Plots of a drive with Matplotlib: the map, and speed, errors and commands over the distance."""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from sdc_common.configuration import how_to_install

try:
    import matplotlib
except ImportError as error:
    raise ImportError(f"matplotlib is missing; {how_to_install('plots')}") from error

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.patheffects import withStroke

from sdc_map.network_file import load_network
from sdc_sim.evaluation.drive_evaluation import COLUMNS, DriveEvaluation
from sdc_sim.evaluation.metrics import accelerations
from sdc_sim.evaluation.route_progress import COMPLETED
from sdc_sim.yaml_document import packaged_config

# The colours are dark enough for a wall and differ for people with colour blindness.
ERROR_COLOURS = LinearSegmentedColormap.from_list(
    "error", ["#2b6cb0", "#2b9db0", "#e0a800", "#d1341f", "#8b0000"]
)
GREEN, RED, GREY, BLACK = "#2e8b57", "#c0392b", "#5f6368", "#202124"
DRIVEN, PLANNED, LIMIT, ROAD = "#1f5fa8", "#f5c26b", "#9aa0a6", "#dfe3e8"
_PAGE = packaged_config("report_page")
EVENT_NAMES: dict[str, str] = _PAGE["event_names"]
SPEED_REASONS: dict[str, str] = _PAGE["speed_reasons"]
# A drawing on the page is as wide as a phone shows it readably, or half of a screen.
_SVG_WIDTH_IN = 6.0
_SVG_FONT_PT = 11.0
# More points are not visible and make the page large.
_MAX_POINTS = 4000
_MAX_COLOURED_PIECES = 1200
_MAX_ROAD_POINTS = 20_000
_MIN_ERROR_SCALE_M = 0.1


def thinned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a line (n,) with at most about 4000 points, which keeps local extremes."""
    if len(x) <= _MAX_POINTS:
        return x, y
    filled = np.nan_to_num(y)
    keep: set[int] = set()
    for part in np.array_split(np.arange(len(x)), _MAX_POINTS // 2):
        keep.update((int(part[filled[part].argmin()]), int(part[filled[part].argmax()])))
    index = sorted(keep)
    return x[index], y[index]


def map_and_panels(figure: Figure, panels: dict, top: float) -> tuple[Axes, list[Axes]]:
    """Return axes for a map in metres and, at its right, for panels over the distance.

    Args:
        figure: an empty figure
        panels: rows of PANELS
        top: upper end of the axes as a share of the figure
    """
    margins = {"left": 0.055, "right": 0.985, "top": top, "bottom": 0.07, "wspace": 0.13}
    grid = figure.add_gridspec(1, 2, width_ratios=(1.0, 1.1), **margins)
    return _map_axes(figure.add_subplot(grid[0])), _panel_axes(grid[1], panels)


def _map_axes(axes: Axes) -> Axes:
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.06)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    return axes


def _panel_axes(cell: SubplotSpec, panels: dict) -> list[Axes]:
    heights = [height for height, _ in panels.values()]
    grid = cell.subgridspec(len(panels), 1, height_ratios=heights, hspace=0.42)
    every = grid.subplots(sharex=True, squeeze=False)[:, 0].tolist()
    for axes, title in zip(every, panels):
        axes.set_title(title, loc="left", fontsize="medium", color=BLACK, pad=4)
        axes.grid(alpha=0.25)
    every[-1].set_xlabel("distance along the route [m]")
    return every


def _infractions(result: DriveEvaluation) -> list:
    progress = result.progress
    return [event for event in progress.events if event.name in progress.infractions]


def draw_map(axes: Axes, result: DriveEvaluation) -> None:
    """Draw the route, the driven line coloured by its cross-track error, and the infractions."""
    route, progress = result.progress.route.points, result.progress
    road = np.vstack([route[:: len(route) // _MAX_ROAD_POINTS + 1], route[-1]]).T
    if progress.rules.map:
        lanes = [lane.points_m for lane in load_network(progress.rules.map).driving]
        axes.add_collection(LineCollection(lanes, color=ROAD, linewidth=2), autolim=False)
    round_ends: dict[str, Any] = {"solid_capstyle": "round", "solid_joinstyle": "round"}
    axes.plot(*road, color=ROAD, linewidth=12, zorder=1, **round_ends)
    axes.plot(*road, color="white", linewidth=1, dashes=(4, 4), zorder=2)
    line = _driven_line(progress.rows)
    axes.add_collection(line)
    marks: list = [
        (route[0], "o", GREEN, 13, 4, "start"),
        (route[-1], "s", BLACK, 12, 4, "end of the route"),
    ]
    if progress.status != COMPLETED:
        last = progress.samples[-1]
        marks.append(((last.x_m, last.y_m), "X", RED, 15, 6, "end of the drive"))
    for event in _infractions(result):
        marks.append(((event.x_m, event.y_m), "v", RED, 13, 5, None))
        axes.annotate(
            EVENT_NAMES[event.name],
            (event.x_m, event.y_m),
            xytext=(8, 8),
            textcoords="offset points",
            zorder=7,
            color=RED,
            weight="bold",
            path_effects=[withStroke(linewidth=4, foreground="white")],
        )
    for point, marker, colour, size, zorder, label in marks:
        style = {"color": colour, "markersize": size, "zorder": zorder, "label": label}
        axes.plot(*point, marker, markeredgecolor="white", **style)
    axes.legend(loc="best", framealpha=0.9)
    place: dict[str, Any] = {"location": "top", "fraction": 0.035, "aspect": 45, "pad": 0.02}
    axes.figure.colorbar(line, ax=axes, label="cross-track error [m]", **place)


def _driven_line(rows: np.ndarray) -> LineCollection:
    """Return the line through the rows of a drive, coloured by the cross-track error."""
    points, error = rows[:, 1:3], np.abs(rows[:, COLUMNS.index("cross_track_m")])
    parts = np.array_split(np.arange(len(points)), min(len(points), _MAX_COLOURED_PIECES))
    line = LineCollection(
        # Each piece begins with the last point of the one before, or the line would have gaps.
        [points[max(part[0] - 1, 0) : part[-1] + 1] for part in parts],
        array=np.array([error[part].max() for part in parts]),
        cmap=ERROR_COLOURS,
        linewidth=5,
        capstyle="round",
        zorder=3,
    )
    line.set_clim(0.0, max(float(error.max()), _MIN_ERROR_SCALE_M))
    return line


def _draw_speed(axes: Axes, result: DriveEvaluation, columns: dict) -> None:
    """Draw the driven and the planned speed, and the greatest that the planner's limits allow."""
    limit = thinned(result.progress.route.s, result.ideal.speed_mps)
    axes.plot(*limit, color=LIMIT, linewidth=1.5, dashes=(3, 2), label="limit", zorder=2.5)
    if result.planned:
        s_m, speed_mps, _ = np.array(result.planned).T
        axes.plot(*thinned(s_m, speed_mps), color=PLANNED, linewidth=6, label="planned")
    axes.plot(*thinned(columns["s_m"], columns["speed_mps"]), color=DRIVEN, label="driven")
    axes.set_ylim(bottom=0.0)
    _add_legend(axes)


def _draw_pedals(axes: Axes, _result: DriveEvaluation, columns: dict) -> None:
    """Draw the throttle upwards and the brake downwards."""
    for name, sign, colour in (("throttle", 1.0, GREEN), ("brake", -1.0, RED)):
        x, y = thinned(columns["s_m"], sign * columns[name])
        axes.fill_between(x, y, color=colour, alpha=0.75, linewidth=0.8, label=name)
    axes.axhline(0.0, color="0.6", linewidth=1)
    axes.set_ylim(-1.05, 1.05)
    axes.set_yticks([-1.0, 0.0, 1.0], ["1", "0", "1"])
    _add_legend(axes)


def _draw_lateral(axes: Axes, _result: DriveEvaluation, columns: dict) -> None:
    time_s, s_m = columns["time_s"], columns["s_m"]
    for part_s, _, lateral, _ in accelerations(time_s, columns["speed_mps"], columns["yaw_rad"]):
        axes.plot(*thinned(np.interp(part_s, time_s, s_m), lateral), color=DRIVEN)
    axes.axhline(0.0, color="0.6", linewidth=1, zorder=0)


def _around_zero(name: str, least_range: float, scale: float = 1.0) -> Callable:
    """Return the function that draws a column around zero."""

    def draw(axes: Axes, _result: DriveEvaluation, columns: dict) -> None:
        values = scale * columns[name]
        axes.axhline(0.0, color="0.6", linewidth=1, zorder=0)
        axes.plot(*thinned(columns["s_m"], values), color=DRIVEN)
        # A command that was refused is NaN or infinite.
        largest = float(np.max(np.abs(values), where=np.isfinite(values), initial=0.0))
        limit = max(1.1 * largest, least_range)
        axes.set_ylim(-limit, limit)

    return draw


def _add_legend(axes: Axes) -> None:
    place: dict = {"loc": "lower right", "bbox_to_anchor": (1.0, 0.98), "ncol": 3}
    axes.legend(frameon=False, borderpad=0.0, handlelength=1.5, **place)


# Title, relative height and drawing function of each panel, from top to bottom, and of the others
# those that a drive without commands lacks.
PANELS = {
    "speed [m/s]": (1.6, _draw_speed),
    "cross-track error [m], left is positive": (1.2, _around_zero("cross_track_m", 0.05)),
    "heading error [degrees], left is positive": (
        *(1.0, _around_zero("heading_error_rad", 2.0, math.degrees(1.0))),
    ),
    "steer, right is positive": (1.0, _around_zero("steer", 0.1)),
    "pedals": (1.0, _draw_pedals),
    "lateral acceleration [m/s²], left is positive": (1.0, _draw_lateral),
}
_OF_COMMANDS = ("steer, right is positive", "pedals")


def _shown_panels(result: DriveEvaluation) -> dict:
    """Return the rows of PANELS for which a drive has data."""
    left_out = _OF_COMMANDS if np.isnan(result.commands).all() else ()
    return {title: panel for title, panel in PANELS.items() if title not in left_out}


def _draw_panels(panels: list[Axes], result: DriveEvaluation) -> None:
    columns = dict(zip(COLUMNS, result.rows.T))
    for axes, (_, draw) in zip(panels, _shown_panels(result).values()):
        draw(axes, result, columns)
        for event in _infractions(result):
            axes.axvline(event.s_m, color=RED, linewidth=1.5, dashes=(2, 2))
    panels[0].set_xlim(0.0, result.progress.route.length_m)


def new_figure(width_in: float, height_in: float, font_size_pt: float) -> Figure:
    """Return an empty figure of a width and a height [inches] with a font size [points]."""
    matplotlib.rcParams.update(
        {**_PAGE["style"], "font.size": font_size_pt, "legend.fontsize": 0.9 * font_size_pt}
    )
    return Figure(figsize=(width_in, height_in))


def headline(metrics: dict) -> list[tuple[str, str]]:
    """Return names and values of the most important metrics, as text."""
    words = {True: "yes", False: "no"}
    values = {**metrics, "comfortable": words.get(metrics["comfortable"])}
    if metrics["status"] != COMPLETED:
        values["time_ratio"] = None
    return [
        (name, "-" if values[metric] is None else form.format(values[metric]))
        for name, metric, form in _PAGE["headline"]
    ]


def write_png(path: str, result: DriveEvaluation) -> None:
    """Write report.png: headline, map and panels on one wide page."""
    metrics = result.metrics
    status, shown = metrics["status"], headline(metrics)
    figure = new_figure(16.0, 9.0, 12.0)
    bold: dict[str, Any] = {"weight": "bold", "va": "center"}
    colour = GREEN if status == COMPLETED else RED
    figure.text(0.02, 0.945, status.replace("_", " "), fontsize=30, color=colour, **bold)
    for number, (name, value) in enumerate(shown):
        x = 0.215 + number * 0.79 / len(shown)
        figure.text(x, 0.962, value, fontsize=20, color=BLACK, **bold)
        figure.text(x, 0.925, name, fontsize=12, color=GREY, va="center")
    on_map, panels = map_and_panels(figure, _shown_panels(result), 0.86)
    draw_map(on_map, result)
    _draw_panels(panels, result)
    figure.savefig(path, format="png", dpi=100, facecolor="white")


def svg_map(result: DriveEvaluation) -> str:
    """Return the map as SVG."""
    span = np.ptp(result.progress.route.points, axis=0) + 20.0
    height = 1.6 + min(max(0.9 * _SVG_WIDTH_IN * span[1] / span[0], 2.5), _SVG_WIDTH_IN)
    figure = new_figure(_SVG_WIDTH_IN, height, _SVG_FONT_PT)
    axes = figure.add_axes((0.11, 0.6 / height, 0.865, 1.0 - 1.3 / height))
    draw_map(_map_axes(axes), result)
    return _svg(figure, "map")


def svg_panels(result: DriveEvaluation) -> str:
    """Return all panels over the distance as SVG."""
    shown = _shown_panels(result)
    height = 1.0 + 1.4 * sum(height for height, _ in shown.values())
    figure = new_figure(_SVG_WIDTH_IN, height, _SVG_FONT_PT)
    margins = {"left": 0.11, "right": 0.97, "top": 1.0 - 0.4 / height, "bottom": 0.6 / height}
    _draw_panels(_panel_axes(figure.add_gridspec(1, 1, **margins)[0], shown), result)
    return _svg(figure, "panels")


def _svg(figure: Figure, name: str) -> str:
    file = io.StringIO()
    # Without a date, the same drive gives the same file.
    figure.savefig(file, format="svg", metadata={"Date": None}, transparent=True)
    text = file.getvalue()
    for colour, name_on_page in _PAGE["page_colours"].items():
        text = text.replace(colour, f"var(--{name_on_page})")
    # Matplotlib uses the same ids in every drawing; on one page they must differ.
    for mark in ('id="', 'href="#', "url(#"):
        text = text.replace(mark, f"{mark}{name}-")
    return text[text.index("<svg") :]
