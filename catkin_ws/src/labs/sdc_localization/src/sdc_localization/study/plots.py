"""The pictures of docs/labs/localization.md: the town on the estimate, with a GNSS outage.

python3 -m sdc_localization.study.plots [FOLDER]
"""

from __future__ import annotations

import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
import rospkg  # noqa: E402
from matplotlib.axes import Axes  # noqa: E402
from matplotlib.patches import Ellipse  # noqa: E402

from sdc_common.routes.waypoint_file import load_waypoints  # noqa: E402
from sdc_localization.study.drives import LocalizedDrive, drive_localized  # noqa: E402

OUTAGE_S = (60.0, 65.0)
BLUE, RED, GREEN, GREY = "#2a6fb0", "#c2402f", "#3a8a4d", "#999999"
# The ellipses are drawn so many times larger than they are.
_MAGNIFIED = 30.0
_ELLIPSE_EVERY = 20  # ticks
_STYLE = {"axes.spines.top": False, "axes.spines.right": False, "font.size": 10, "savefig.dpi": 110}


def dead_reckoning(drive: LocalizedDrive, axes: Axes) -> None:
    """Draw the road as wheels and gyroscope, GNSS, and the filter see it."""
    truth, alone = drive.truth, drive.dead_reckoned
    axes.plot(*drive.fixes.T, ".", color=GREY, ms=1.5, alpha=0.5, label="GNSS positions")
    axes.plot(*truth[:, :2].T, color="black", lw=3.0, label="truth")
    axes.plot(*alone.T, color=RED, lw=1.5, label="wheels and gyroscope alone")
    axes.plot(*drive.estimates[:, :2].T, color=GREEN, lw=1.2, label="the filter")
    error = np.hypot(*(alone[-1] - truth[-1, :2]))
    axes.annotate(f"{error:.1f} m off", alone[-1], xytext=(8, 8), textcoords="offset points")
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))


def errors(drive: LocalizedDrive, axes: Axes) -> None:
    """Draw the error of the position over time, with what the filter believes of it."""
    time_s = drive.times_s
    believed = np.sqrt(np.trace(drive.covariances[:, :2, :2], axis1=1, axis2=2))
    fixes = np.hypot(*(drive.fixes - drive.truth[:, :2]).T)
    alone = np.hypot(*(drive.dead_reckoned - drive.truth[:, :2]).T)
    axes.axvspan(*OUTAGE_S, color=RED, alpha=0.12, label="no GNSS")
    axes.plot(time_s, fixes, ".", color=GREY, ms=1.5, alpha=0.6, label="GNSS positions")
    axes.plot(time_s, alone, color=RED, lw=1.5, label="wheels and gyroscope alone")
    axes.fill_between(time_s, 0.0, 2.0 * believed, color=BLUE, alpha=0.25, label="2 sigma")
    axes.plot(time_s, drive.position_errors_m, color=GREEN, lw=1.5, label="the filter")
    axes.set_ylim(0.0, 3.0)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("distance from the truth [m]")
    axes.legend(frameon=False, loc="upper right", ncols=2)


def ellipse(drive: LocalizedDrive, axes: Axes) -> None:
    """Draw the ellipses of the covariance around the outage, magnified."""
    begin, end = np.searchsorted(drive.times_s, (OUTAGE_S[0] - 10.0, OUTAGE_S[1] + 10.0))
    axes.plot(*drive.truth[begin:end, :2].T, color="black", lw=1.0, label="truth")
    for index in range(begin, end, _ELLIPSE_EVERY):
        sizes, axes_of = np.linalg.eigh(drive.covariances[index, :2, :2])
        inside = OUTAGE_S[0] <= drive.times_s[index] < OUTAGE_S[1]
        axes.add_patch(
            Ellipse(
                tuple(drive.estimates[index, :2]),
                *(2.0 * _MAGNIFIED * np.sqrt(sizes)),
                angle=float(np.degrees(np.arctan2(axes_of[1, 0], axes_of[0, 0]))),
                facecolor="none",
                edgecolor=RED if inside else BLUE,
                lw=1.5,
            )
        )
    axes.plot([], [], color=BLUE, label=f"1 sigma, {_MAGNIFIED:.0f} times larger")
    axes.plot([], [], color=RED, label="the same without GNSS")
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))


PICTURES = (dead_reckoning, errors, ellipse)


def main() -> None:
    """Write the pictures."""
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.join("docs", "labs")
    path = os.path.join(rospkg.RosPack().get_path("sdc_common"), "data", "waypoints.csv")
    outage = {"from_s": OUTAGE_S[0], "to_s": OUTAGE_S[1]}
    drive = drive_localized(load_waypoints(path), gnss={"outages": [outage]})
    with plt.rc_context(_STYLE):
        for picture in PICTURES:
            figure, axes = plt.subplots(figsize=(9.0, 5.5), layout="constrained")
            picture(drive, axes)
            figure.savefig(os.path.join(folder, f"localization_{picture.__name__}.png"))
            plt.close(figure)


if __name__ == "__main__":
    main()
