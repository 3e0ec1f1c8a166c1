"""Plots of a drive with Matplotlib: the map, and speed, errors and commands over the distance."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.patheffects import withStroke

from sdc_sim.evaluation.drive_evaluation import DriveResult
from sdc_sim.evaluation.metrics import accelerations
from sdc_sim.evaluation.route_progress import COMPLETED

# The colours are dark enough for a wall and differ for people with colour blindness.
ERROR_COLOURS = LinearSegmentedColormap.from_list(
    "error", ["#2b6cb0", "#2b9db0", "#e0a800", "#d1341f", "#8b0000"]
)
GREEN, RED, GREY, BLACK = "#2e8b57", "#c0392b", "#5f6368", "#202124"
DRIVEN, PLANNED, LIMIT, ROAD = "#1f5fa8", "#f5c26b", "#9aa0a6", "#dfe3e8"
EVENT_NAMES = {
    "collision_pedestrian": "hit a pedestrian",
    "collision_vehicle": "hit a vehicle",
    "collision_static": "hit an object",
    "red_light": "ran a red light",
    "stop": "ran a stop sign",
    "completed": "arrived",
    "collision": "ended by a collision",
    "off_route": "off the route",
    "blocked": "blocked",
    "timeout": "out of time",
    "aborted": "aborted",
}
_RC_PARAMS: dict = {
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": GREY,
    "lines.linewidth": 1.8,
    "axes.labelcolor": BLACK,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "svg.fonttype": "path",
    "font.family": "sans-serif",
    "svg.hashsalt": "sdc",
    "path.simplify_threshold": 0.3,
}

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


def draw_map(axes: Axes, result: DriveResult) -> None:
    """Draw the route, the driven line coloured by its cross-track error, and the infractions."""
    _draw_road(axes, result.progress.route.points)
    line = _draw_driven_line(axes, result)
    _draw_ends(axes, result)
    _draw_infractions(axes, result)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.06)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.legend(loc="best", framealpha=0.9)
    axes.figure.colorbar(
        line,
        ax=axes,
        location="top",
        fraction=0.035,
        aspect=45,
        pad=0.02,
        label="cross-track error [m]",
    )


def _draw_road(axes: Axes, route: np.ndarray) -> None:
    road = np.vstack([route[:: len(route) // _MAX_ROAD_POINTS + 1], route[-1]])
    axes.plot(
        *road.T, color=ROAD, linewidth=12, solid_capstyle="round", solid_joinstyle="round", zorder=1
    )
    axes.plot(*road.T, color="white", linewidth=1, dashes=(4, 4), zorder=2)


def _draw_driven_line(axes: Axes, result: DriveResult) -> LineCollection:
    progress = result.progress
    points = np.column_stack([progress.column("x_m"), progress.column("y_m")])
    error = np.abs(progress.column("cross_track_m"))
    count = min(len(points), _MAX_COLOURED_PIECES)
    parts = [part for part in np.array_split(np.arange(len(points)), count) if len(part)]
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
    axes.add_collection(line)
    return line


def _draw_ends(axes: Axes, result: DriveResult) -> None:
    route, last = result.progress.route.points, result.progress.samples[-1]
    marks: list = [
        (route[0], "o", GREEN, 13, 4, "start"),
        (route[-1], "s", BLACK, 12, 4, "end of the route"),
    ]
    if result.progress.status != COMPLETED:
        marks.append(((last.x_m, last.y_m), "X", RED, 15, 6, "end of the drive"))
    for point, marker, colour, size, zorder, label in marks:
        axes.plot(
            *point,
            marker,
            color=colour,
            markeredgecolor="white",
            markersize=size,
            zorder=zorder,
            label=label,
        )


def _infractions(result: DriveResult) -> list:
    progress = result.progress
    return [event for event in progress.events if event.name in progress.infractions]


def _draw_infractions(axes: Axes, result: DriveResult) -> None:
    for event in _infractions(result):
        place = event.x_m, event.y_m
        axes.plot(*place, "v", color=RED, markeredgecolor="white", markersize=13, zorder=5)
        axes.annotate(
            EVENT_NAMES[event.name],
            place,
            xytext=(8, 8),
            textcoords="offset points",
            zorder=7,
            color=RED,
            weight="bold",
            path_effects=[withStroke(linewidth=4, foreground="white")],
        )


def draw_speed(axes: Axes, result: DriveResult) -> None:
    """Draw the driven and the planned speed, and the greatest that the planner's limits allow."""
    progress = result.progress
    axes.plot(
        *thinned(progress.route.s, result.limit_mps),
        color=LIMIT,
        linewidth=1.5,
        dashes=(3, 2),
        label="limit",
        zorder=2.5,
    )
    if len(result.planned):
        axes.plot(*thinned(*result.planned[:, :2].T), color=PLANNED, linewidth=6, label="planned")
    axes.plot(
        *thinned(progress.column("s_m"), progress.column("speed_mps")), color=DRIVEN, label="driven"
    )
    axes.set_ylim(bottom=0.0)
    _set_title(axes, "speed [m/s]")
    _add_legend(axes)


def draw_cross_track(axes: Axes, result: DriveResult) -> None:
    """Draw the cross-track error."""
    error_m = result.progress.column("cross_track_m")
    _draw_signed(axes, result, error_m, "cross-track error [m], left is positive", 0.05)


def draw_heading(axes: Axes, result: DriveResult) -> None:
    """Draw the heading error."""
    error_deg = np.degrees(result.progress.column("heading_error_rad"))
    _draw_signed(axes, result, error_deg, "heading error [degrees], left is positive", 2.0)


def draw_steer(axes: Axes, result: DriveResult) -> None:
    """Draw the steering command."""
    _draw_signed(axes, result, result.commands[:, 2], "steer, right is positive", 0.1)


def draw_pedals(axes: Axes, result: DriveResult) -> None:
    """Draw the throttle upwards and the brake downwards."""
    s = result.progress.column("s_m")
    for column, sign, colour, name in ((0, 1.0, GREEN, "throttle"), (1, -1.0, RED, "brake")):
        x, y = thinned(s, sign * result.commands[:, column])
        axes.fill_between(x, y, color=colour, alpha=0.75, linewidth=0.8, label=name)
    axes.axhline(0.0, color="0.6", linewidth=1)
    axes.set_ylim(-1.05, 1.05)
    axes.set_yticks([-1.0, 0.0, 1.0], ["1", "0", "1"])
    _set_title(axes, "pedals")
    _add_legend(axes)


def draw_lateral(axes: Axes, result: DriveResult) -> None:
    """Draw the lateral acceleration."""
    column = result.progress.column
    time_s, s_m = column("time_s"), column("s_m")
    for part_s, _, lateral, _ in accelerations(time_s, column("speed_mps"), column("yaw_rad")):
        axes.plot(*thinned(np.interp(part_s, time_s, s_m), lateral), color=DRIVEN)
    axes.axhline(0.0, color="0.6", linewidth=1, zorder=0)
    _set_title(axes, "lateral acceleration [m/s²], left is positive")


def _draw_signed(
    axes: Axes, result: DriveResult, values: np.ndarray, title: str, min_range: float
) -> None:
    axes.axhline(0.0, color="0.6", linewidth=1, zorder=0)
    axes.plot(*thinned(result.progress.column("s_m"), values), color=DRIVEN)
    limit = max(1.1 * float(np.nanmax(np.abs(values))), min_range)
    axes.set_ylim(-limit, limit)
    _set_title(axes, title)


def _set_title(axes: Axes, text: str) -> None:
    axes.set_title(text, loc="left", fontsize="medium", color=BLACK, pad=4)


def _add_legend(axes: Axes) -> None:
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 0.98),
        ncol=3,
        frameon=False,
        borderpad=0.0,
        handlelength=1.5,
    )


def panels(result: DriveResult) -> list[tuple[Callable[[Axes, DriveResult], None], float]]:
    """Return the drawing function and relative height of each panel, from top to bottom."""
    chosen = [(draw_speed, 1.6), (draw_cross_track, 1.2), (draw_heading, 1.0)]
    if not np.isnan(result.commands).all():
        chosen += [(draw_steer, 1.0), (draw_pedals, 1.0)]
    return [*chosen, (draw_lateral, 1.0)]


def draw_panels(figure: Figure, cell: SubplotSpec, result: DriveResult) -> None:
    """Draw the panels below each other into a cell of a grid, with a common axis of distance."""
    chosen = panels(result)
    grid = cell.subgridspec(
        len(chosen), 1, height_ratios=[height for _, height in chosen], hspace=0.42
    )
    shared: Any = None
    for row, (draw, _) in enumerate(chosen):
        axes = shared = figure.add_subplot(grid[row], sharex=shared)
        draw(axes, result)
        axes.grid(alpha=0.25)
        for event in _infractions(result):
            axes.axvline(event.s_m, color=RED, linewidth=1.5, dashes=(2, 2))
        if row < len(chosen) - 1:
            axes.tick_params(labelbottom=False)
    shared.set_xlim(0.0, result.progress.route.length_m)
    shared.set_xlabel("distance along the route [m]")


def new_figure(width_in: float, height_in: float, font_size_pt: float) -> Figure:
    """Return an empty figure with a canvas.

    Args:
        width_in: width [inches]
        height_in: height [inches]
        font_size_pt: font size [points]
    """
    matplotlib.rcParams.update(
        {**_RC_PARAMS, "font.size": font_size_pt, "legend.fontsize": 0.9 * font_size_pt}
    )
    figure = Figure(figsize=(width_in, height_in))
    FigureCanvasAgg(figure)
    return figure


def headline(metrics: dict) -> list[tuple[str, str]]:
    """Return names and values of the most important metrics, as text."""

    def number(value: float | None, form: str, unit: str = "") -> str:
        return "-" if value is None else f"{value:{form}}{unit}"

    arrived = metrics["status"] == COMPLETED
    return [
        ("of the route", number(metrics["route_completion_percent"], ".0f", " %")),
        ("driving score", number(metrics["driving_score"], ".0f")),
        ("error, RMS", number(metrics["cross_track_rms_m"], ".3f", " m")),
        ("error at worst", number(metrics["cross_track_max_m"], ".3f", " m")),
        ("duration", number(metrics["duration_s"], ".1f", " s")),
        ("x least duration", number(metrics["time_ratio"] if arrived else None, ".2f")),
        ("mean speed", number(metrics["speed_mean_mps"], ".1f", " m/s")),
        ("comfortable", {True: "yes", False: "no", None: "-"}[metrics["comfortable"]]),
    ]


def write_png(path: str, result: DriveResult) -> None:
    """Write report.png: headline, map and panels on one wide page.

    Args:
        path: of the image
        result: the evaluated drive

    Raises:
        OSError: the file cannot be written
    """
    metrics = result.metrics
    figure = new_figure(16.0, 9.0, 12.0)
    figure.text(
        0.02,
        0.945,
        metrics["status"].replace("_", " "),
        fontsize=30,
        weight="bold",
        color=GREEN if metrics["status"] == COMPLETED else RED,
        va="center",
    )
    shown = headline(metrics)
    for number, (name, value) in enumerate(shown):
        x = 0.215 + number * 0.79 / len(shown)
        figure.text(x, 0.962, value, fontsize=20, weight="bold", color=BLACK, va="center")
        figure.text(x, 0.925, name, fontsize=12, color=GREY, va="center")
    grid = figure.add_gridspec(
        1, 2, width_ratios=(1.0, 1.1), left=0.055, right=0.985, top=0.86, bottom=0.07, wspace=0.13
    )
    draw_map(figure.add_subplot(grid[0]), result)
    draw_panels(figure, grid[1], result)
    figure.savefig(path, format="png", dpi=100, facecolor="white")


def svg_map(file: io.BytesIO, result: DriveResult) -> None:
    """Write the map as SVG."""
    span = np.ptp(result.progress.route.points, axis=0) + 20.0
    width = 15.0
    height = 2.0 + min(max(0.92 * width * span[1] / span[0], 2.5), 9.0)
    figure = new_figure(width, height, 14.0)
    axes = figure.add_axes((0.07, 0.75 / height, 0.905, 1.0 - 1.5 / height))
    draw_map(axes, result)
    _save_svg(figure, file)


def svg_panels(file: io.BytesIO, result: DriveResult) -> None:
    """Write all panels over the distance as SVG."""
    height = 1.2 + 2.2 * sum(height for _, height in panels(result))
    figure = new_figure(15.0, height, 14.0)
    grid = figure.add_gridspec(
        1, 1, left=0.06, right=0.99, top=1.0 - 0.4 / height, bottom=0.8 / height
    )
    draw_panels(figure, grid[0], result)
    _save_svg(figure, file)


def _save_svg(figure: Figure, file: io.BytesIO) -> None:
    # Without a date, the same drive gives the same file.
    figure.savefig(file, format="svg", metadata={"Date": None}, transparent=True)
