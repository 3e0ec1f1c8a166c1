"""Writes what a drive measured: report.json, a trace of every tick, and a picture."""
from __future__ import annotations

import csv
import json
import os
from dataclasses import astuple, fields

from sdc_sim.drive import Drive, Sample


class ReportError(OSError):
    """The report cannot be written; the message names the file and the mend."""


def check_writable(report_path: str) -> None:
    """Make the report's folder and remove an older report, so that none is taken for the new one. Raises ReportError."""
    try:
        os.makedirs(os.path.dirname(report_path) or ".", exist_ok=True)
        for path in (report_path, *_companions(report_path)):
            if os.path.exists(path):
                os.remove(path)
        with open(report_path, "w", encoding="utf-8"):
            pass
        os.remove(report_path)
    except OSError as error:
        raise ReportError(f"{error.filename or report_path}: {error.strerror}; name a file in a folder that can be written to "
                          "with report:=FILE") from error


def _companions(report_path: str):
    stem = os.path.splitext(report_path)[0]
    return stem + ".csv", stem + ".png"


def write_report(report_path: str, figures: dict, drive: Drive) -> None:
    """Write the figures as JSON, last of all files, beside a CSV of every sample and a PNG. Raises ReportError."""
    trace_path, picture_path = _companions(report_path)
    try:
        write_trace(trace_path, drive)
        draw(picture_path, figures, drive)
        with open(report_path + ".part", "w", encoding="utf-8") as file:
            json.dump(figures, file, indent=2)
            file.write("\n")
        os.replace(report_path + ".part", report_path)
    except OSError as error:
        raise ReportError(f"{error.filename or report_path}: {error.strerror}; the drive was not reported") from error


def write_trace(path: str, drive: Drive) -> None:
    """One row a sample, with every digit: two traces are equal when the drives were."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(field.name for field in fields(Sample))
        writer.writerows(astuple(sample) for sample in drive.samples)


def draw(path: str, figures: dict, drive: Drive) -> None:
    """A picture of the drive: the map coloured by cross-track error, and speed and error over the distance."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    route = drive.route.points
    s = drive.column("s_m")
    error = drive.column("cross_track_m")
    figure = pyplot.figure(figsize=(14, 7), constrained_layout=True)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.1, 1.0))
    on_map = figure.add_subplot(grid[:, 0])
    on_map.plot(route[:, 0], route[:, 1], color="0.8", linewidth=7, solid_capstyle="round", zorder=1)
    worst = max(float(abs(error).max()), 1e-3)
    dots = on_map.scatter(drive.column("x_m"), drive.column("y_m"), c=abs(error), s=4, cmap="viridis_r", vmin=0.0, vmax=worst, zorder=2)
    on_map.plot(*route[0], "o", color="tab:green", markersize=9, label="start")
    on_map.plot(*route[-1], "s", color="tab:red", markersize=8, label="end")
    on_map.set_aspect("equal")
    on_map.set_xlabel("x [m]")
    on_map.set_ylabel("y [m]")
    on_map.legend(loc="best")
    figure.colorbar(dots, ax=on_map, shrink=0.7, label="cross-track error [m]")
    speed = figure.add_subplot(grid[0, 1])
    speed.plot(s, drive.column("speed_mps"), color="tab:blue")
    speed.set_ylabel("speed [m/s]")
    cross_track = figure.add_subplot(grid[1, 1], sharex=speed)
    cross_track.axhline(0.0, color="0.7", linewidth=1)
    cross_track.plot(s, error, color="tab:orange")
    cross_track.set_ylabel("cross-track error [m], positive left")
    cross_track.set_xlabel("distance along the route [m]")
    for axes in (speed, cross_track):
        axes.grid(alpha=0.3)
    figure.suptitle(f"{figures['status']}: {figures['route_completion_percent']:.0f} % of {figures['route_length_m']:.0f} m in "
                    f"{figures['duration_s']:.0f} s, cross-track error {figures['cross_track_rms_m']:.3f} m RMS, "
                    f"{figures['cross_track_max_m']:.3f} m at worst", fontsize=14)
    figure.savefig(path, dpi=100)
    pyplot.close(figure)
