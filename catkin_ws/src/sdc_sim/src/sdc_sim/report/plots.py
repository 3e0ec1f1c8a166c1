"""Draws a drive with Matplotlib: the map, and what happened over the distance."""

from __future__ import annotations

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from sdc_sim.evaluation.evaluator import DriveResult
from sdc_sim.evaluation.metrics import accelerations

# A wall is looked at from afar, and by people who see colours differently: blue, yellow, red, all of them dark enough.
ERROR_COLOURS = LinearSegmentedColormap.from_list(
    "error", ["#2b6cb0", "#2b9db0", "#e0a800", "#d1341f", "#8b0000"]
)
DRIVEN, PLANNED, LIMIT, THROTTLE, BRAKE, ROAD = (
    "#1f5fa8",
    "#f5c26b",
    "#9aa0a6",
    "#2e8b57",
    "#c0392b",
    "#dfe3e8",
)
EVENT_NAMES = {
    "collision_pedestrian": "hit a pedestrian",
    "collision_vehicle": "hit a vehicle",
    "collision_static": "hit a thing",
    "red_light": "ran a red light",
    "stop": "ran a stop sign",
    "completed": "arrived",
    "collision": "ended by a collision",
    "off_route": "off the route",
    "blocked": "blocked",
    "timeout": "out of time",
    "aborted": "aborted",
}

# More points than this are not seen, and make a page heavy.
_MOST_POINTS = 4000
_MOST_COLOURS = 1200
_MOST_ROAD_POINTS = 20_000
_LEAST_SCALE_M = 0.1


def thinned(x: np.ndarray, y: np.ndarray):
    """The line (n,) with at most about 4000 points; the highest and the lowest of those that are left out beside each other stay."""
    if len(x) <= _MOST_POINTS:
        return x, y
    bins = np.array_split(np.arange(len(x)), _MOST_POINTS // 2)
    filled = np.nan_to_num(y)
    keep = np.unique(
        [
            index
            for part in bins
            for index in (part[filled[part].argmin()], part[filled[part].argmax()])
        ]
    )
    return x[keep], y[keep]


def draw_map(axes, result: DriveResult) -> None:
    """The route, the driven line coloured by the size of its cross-track error, and what happened on the way."""
    drive = result.drive
    route = drive.route.points
    x, y, error = drive.column("x_m"), drive.column("y_m"), np.abs(drive.column("cross_track_m"))
    road = np.vstack([route[:: len(route) // _MOST_ROAD_POINTS + 1], route[-1]])
    axes.plot(
        *road.T, color=ROAD, linewidth=12, solid_capstyle="round", solid_joinstyle="round", zorder=1
    )
    axes.plot(*road.T, color="white", linewidth=1, dashes=(4, 4), zorder=2)
    parts = [
        part for part in np.array_split(np.arange(len(x)), min(len(x), _MOST_COLOURS)) if len(part)
    ]
    # Every piece begins with the last point of the one before, or the line would have gaps.
    pieces = [
        np.column_stack(
            [x[max(part[0] - 1, 0) : part[-1] + 1], y[max(part[0] - 1, 0) : part[-1] + 1]]
        )
        for part in parts
    ]
    scale_m = max(float(error.max()), _LEAST_SCALE_M)
    line = LineCollection(
        pieces,
        array=np.array([error[part].max() for part in parts]),
        cmap=ERROR_COLOURS,
        linewidth=5,
        capstyle="round",
        zorder=3,
    )
    line.set_clim(0.0, scale_m)
    axes.add_collection(line)
    axes.plot(
        *route[0],
        "o",
        color="#2e8b57",
        markeredgecolor="white",
        markersize=13,
        zorder=4,
        label="start",
    )
    axes.plot(
        *route[-1],
        "s",
        color="#202124",
        markeredgecolor="white",
        markersize=12,
        zorder=4,
        label="end of the route",
    )
    if drive.status != "completed":
        axes.plot(
            x[-1],
            y[-1],
            "X",
            color="#c0392b",
            markeredgecolor="white",
            markersize=15,
            zorder=6,
            label="end of the drive",
        )
    for event in drive.events:
        if event.name in drive.infractions:
            axes.plot(
                event.x_m,
                event.y_m,
                "v",
                color="#c0392b",
                markeredgecolor="white",
                markersize=13,
                zorder=5,
            )
            axes.annotate(
                EVENT_NAMES[event.name],
                (event.x_m, event.y_m),
                xytext=(8, 8),
                textcoords="offset points",
                zorder=7,
                color="#c0392b",
                weight="bold",
                path_effects=[withStroke(linewidth=4, foreground="white")],
            )
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


def draw_speed(axes, result: DriveResult) -> None:
    """Driven, planned, and the most that the planner's limits allow."""
    drive = result.drive
    axes.plot(
        *thinned(drive.route.s, result.limit_mps),
        color=LIMIT,
        linewidth=1.5,
        dashes=(3, 2),
        label="limit",
        zorder=2.5,
    )
    if len(result.planned):
        axes.plot(*thinned(*result.planned.T), color=PLANNED, linewidth=6, label="planned")
    axes.plot(
        *thinned(drive.column("s_m"), drive.column("speed_mps")), color=DRIVEN, label="driven"
    )
    axes.set_ylim(bottom=0.0)
    _title(axes, "speed [m/s]")
    _legend(axes)


def draw_cross_track(axes, result: DriveResult) -> None:
    """Positive to the left of the route."""
    _draw_signed(
        axes,
        result.drive.column("s_m"),
        result.drive.column("cross_track_m"),
        "cross-track error [m], left is positive",
        0.05,
    )


def draw_heading(axes, result: DriveResult) -> None:
    """Positive to the left of the route's direction."""
    error_deg = np.degrees(result.drive.column("heading_error_rad"))
    _draw_signed(
        axes,
        result.drive.column("s_m"),
        error_deg,
        "heading error [degrees], left is positive",
        2.0,
    )


def draw_steer(axes, result: DriveResult) -> None:
    """The command, positive turns right."""
    _draw_signed(
        axes, result.drive.column("s_m"), result.commands[:, 2], "steer, right is positive", 0.1
    )


def draw_pedals(axes, result: DriveResult) -> None:
    """Throttle upwards, brake downwards."""
    s = result.drive.column("s_m")
    for column, sign, colour, name in ((0, 1.0, THROTTLE, "throttle"), (1, -1.0, BRAKE, "brake")):
        x, y = thinned(s, sign * result.commands[:, column])
        axes.fill_between(x, y, color=colour, alpha=0.75, linewidth=0.8, label=name)
    axes.axhline(0.0, color="0.6", linewidth=1)
    axes.set_ylim(-1.05, 1.05)
    axes.set_yticks([-1.0, 0.0, 1.0], ["1", "0", "1"])
    _title(axes, "pedals")
    _legend(axes)


def draw_lateral(axes, result: DriveResult) -> None:
    """Positive to the left."""
    drive = result.drive
    time_s = drive.column("time_s")
    for part_s, _, lateral, _ in accelerations(
        time_s, drive.column("speed_mps"), drive.column("yaw_rad")
    ):
        axes.plot(*thinned(np.interp(part_s, time_s, drive.column("s_m")), lateral), color=DRIVEN)
    axes.axhline(0.0, color="0.6", linewidth=1, zorder=0)
    _title(axes, "lateral acceleration [m/s²], left is positive")


def _draw_signed(axes, s, values, label: str, least: float) -> None:
    axes.axhline(0.0, color="0.6", linewidth=1, zorder=0)
    axes.plot(*thinned(s, values), color=DRIVEN)
    reach = max(1.1 * float(np.nanmax(np.abs(values))), least)
    axes.set_ylim(-reach, reach)
    _title(axes, label)


def _title(axes, text: str) -> None:
    axes.set_title(text, loc="left", fontsize="medium", color="#202124", pad=4)


def _legend(axes) -> None:
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 0.98),
        ncol=3,
        frameon=False,
        borderpad=0.0,
        handlelength=1.5,
    )


def panels(result: DriveResult) -> list:
    """What there is to draw over the distance, in the order from top to bottom: drawing functions and their heights."""
    chosen = [(draw_speed, 1.6), (draw_cross_track, 1.2), (draw_heading, 1.0)]
    if not np.isnan(result.commands).all():
        chosen += [(draw_steer, 1.0), (draw_pedals, 1.0)]
    return [*chosen, (draw_lateral, 1.0)]


def draw_panels(figure, place, result: DriveResult, chosen) -> None:
    """Draw the panels below each other into one cell of a grid, with one axis of distance."""
    grid = place.subgridspec(
        len(chosen), 1, height_ratios=[height for _, height in chosen], hspace=0.42
    )
    first = None
    for row, (draw, _) in enumerate(chosen):
        axes = first = (
            figure.add_subplot(grid[row], sharex=first)
            if first is not None
            else figure.add_subplot(grid[row])
        )
        draw(axes, result)
        axes.grid(alpha=0.25)
        for event in result.drive.events:
            if event.name in result.drive.infractions:
                axes.axvline(event.s_m, color="#c0392b", linewidth=1.5, dashes=(2, 2))
        if row < len(chosen) - 1:
            axes.tick_params(labelbottom=False)
    first.set_xlim(0.0, result.drive.route.length_m)
    first.set_xlabel("distance along the route [m]")


def new_figure(width: float, height: float, size: float) -> Figure:
    """A figure with a canvas (inches), whose letters have this size (points)."""
    import matplotlib

    matplotlib.rcParams.update(
        {
            "font.size": size,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.edgecolor": "#5f6368",
            "lines.linewidth": 1.8,
            "axes.labelcolor": "#202124",
            "xtick.color": "#5f6368",
            "ytick.color": "#5f6368",
            "legend.fontsize": 0.9 * size,
            "svg.fonttype": "path",
            "font.family": "sans-serif",
            "svg.hashsalt": "sdc",
            "path.simplify_threshold": 0.3,
        }
    )
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    return figure


def headline(figures: dict) -> list:
    """What a person asks first: (name, value) pairs."""

    def number(value, form, unit=""):
        return "-" if value is None else f"{value:{form}}{unit}"

    arrived = figures["status"] == "completed"
    return [
        ("of the route", number(figures["route_completion_percent"], ".0f", " %")),
        ("driving score", number(figures["driving_score"], ".0f")),
        ("error, RMS", number(figures["cross_track_rms_m"], ".3f", " m")),
        ("error at worst", number(figures["cross_track_max_m"], ".3f", " m")),
        ("duration", number(figures["duration_s"], ".1f", " s")),
        ("x least duration", number(figures["time_ratio"] if arrived else None, ".2f")),
        ("mean speed", number(figures["speed_mean_mps"], ".1f", " m/s")),
        ("comfortable", {True: "yes", False: "no", None: "-"}[figures["comfortable"]]),
    ]


def draw_glance(path: str, result: DriveResult) -> None:
    """report.png: figures, map and the most telling panels on one wide page."""
    figures = result.figures
    figure = new_figure(16.0, 9.0, 12.0)
    good = figures["status"] == "completed"
    figure.text(
        0.02,
        0.945,
        figures["status"].replace("_", " "),
        fontsize=30,
        weight="bold",
        color="#2e8b57" if good else "#c0392b",
        va="center",
    )
    shown = headline(figures)
    for number, (name, value) in enumerate(shown):
        x = 0.215 + number * 0.79 / len(shown)
        figure.text(x, 0.962, value, fontsize=20, weight="bold", color="#202124", va="center")
        figure.text(x, 0.925, name, fontsize=12, color="#5f6368", va="center")
    grid = figure.add_gridspec(
        1, 2, width_ratios=(1.0, 1.1), left=0.055, right=0.985, top=0.86, bottom=0.07, wspace=0.13
    )
    on_map = figure.add_subplot(grid[0])
    draw_map(on_map, result)
    draw_panels(figure, grid[1], result, panels(result))
    figure.savefig(path, dpi=100, facecolor="white")


def svg_map(file, result: DriveResult) -> None:
    """The map as a drawing."""
    span = np.ptp(result.drive.route.points, axis=0) + 20.0
    width = 15.0
    height = 2.0 + min(max(0.92 * width * span[1] / span[0], 2.5), 9.0)
    figure = new_figure(width, height, 14.0)
    axes = figure.add_axes((0.07, 0.75 / height, 0.905, 1.0 - 1.5 / height))
    draw_map(axes, result)
    figure.savefig(file, format="svg", metadata={"Date": None}, transparent=True)


def svg_panels(file, result: DriveResult) -> None:
    """All panels over the distance as a drawing."""
    chosen = panels(result)
    height = 1.2 + 2.2 * sum(height for _, height in chosen)
    figure = new_figure(15.0, height, 14.0)
    grid = figure.add_gridspec(
        1, 1, left=0.06, right=0.99, top=1.0 - 0.4 / height, bottom=0.8 / height
    )
    draw_panels(figure, grid[0], result, chosen)
    figure.savefig(file, format="svg", metadata={"Date": None}, transparent=True)
