"""Draws a drive."""
from __future__ import annotations


def draw(path: str, result) -> None:
    """A picture of the drive: the map coloured by cross-track error, and speed and error over the distance."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    drive, figures = result.drive, result.figures
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
