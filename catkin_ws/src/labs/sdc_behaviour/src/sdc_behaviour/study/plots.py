"""The pictures of docs/labs/behaviour.md.

python3 -m sdc_behaviour.study.plots [FOLDER]
"""

from __future__ import annotations

import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.axes import Axes  # noqa: E402

from sdc_behaviour.drives import drive_scene  # noqa: E402
from sdc_behaviour.monitor import always  # noqa: E402
from sdc_behaviour.rss import Rss  # noqa: E402
from sdc_behaviour.study.experiments import SEEDS, flow_per_h  # noqa: E402

BLUE, RED, GREEN, GREY = "#2a6fb0", "#c2402f", "#3a8a4d", "#999999"
_STYLE = {"axes.spines.top": False, "axes.spines.right": False, "font.size": 10, "savefig.dpi": 110}
_RESPONSES_S = (0.1, 0.3, 0.6, 1.0, 1.5, 2.0)


def drive(left: Axes, right: Axes) -> None:
    """Draw an overtaking manoeuvre from above, and the speed at the junction of several drives."""
    rows = drive_scene("lorry", 2).rows
    picture = left.scatter(rows[:, 1], rows[:, 4], c=rows[:, 2], s=4, cmap="viridis")
    plt.colorbar(picture, ax=left, label="speed [m/s]")
    for y in (-1.75, 1.75, 5.25):
        left.axhline(y, color=GREY, lw=1.0, ls="--" if y == 1.75 else "-")
    left.set(xlabel="x [m]", ylabel="y [m]", ylim=(-8, 12), title="Behind a lorry, and past it")
    for seed, colour in zip((1, 2, 5), (BLUE, RED, GREEN)):
        rows = drive_scene("crossing", seed).rows
        right.plot(rows[:, 1], rows[:, 2], color=colour, label=f"seed {seed}")
    right.axvline(300.0, color="black", lw=1.0, ls=":")
    right.set(xlabel="x [m]", ylabel="speed [m/s]", title="Giving way at x = 300 m")
    right.legend(frameon=False)


def rss(left: Axes, right: Axes) -> None:
    """Draw the flow of a lane with the safe distance, and mean speeds of drives behind a lorry."""
    speeds = np.linspace(1.0, 30.0, 100)
    for response_s, colour in zip((0.3, 1.0, 2.0), (GREEN, BLUE, RED)):
        flow = flow_per_h(speeds, Rss(response_s=response_s))
        left.plot(speeds, flow, color=colour, label=f"reaction {response_s:g} s")
    left.plot(speeds, 3600.0 * speeds / (2.0 * speeds + 6.7), color=GREY, ls="--", label="2 s gap")
    left.set(xlabel="speed [m/s]", ylabel="cars an hour on a lane", ylim=(0, None))
    left.legend(frameon=False)
    means = []
    for response_s in _RESPONSES_S:
        worst = Rss(response_s=response_s)
        means.append([drive_scene("lorry", one, rss=worst).mean_mps for one in SEEDS])
    right.plot(_RESPONSES_S, np.mean(means, axis=1), "o-", color=BLUE)
    right.set(xlabel="reaction time in the safe distance [s]", ylabel="mean speed [m/s]")
    right.set_title(f"{len(SEEDS)} drives behind a lorry")


def monitor(left: Axes, right: Axes) -> None:
    """Draw the gap in a column that brakes, and the robustness of two seconds of distance."""
    rows = drive_scene("brake", 2).rows
    time_s, gap_m, speed_mps = rows[:, 0], rows[:, 3], rows[:, 2]
    margin_m = gap_m - 2.0 * speed_mps
    left.plot(time_s, np.minimum(gap_m, 80.0), color=BLUE, label="gap [m]")
    left.plot(time_s, 2.0 * speed_mps, color=GREY, ls="--", label="two seconds [m]")
    right.axhline(0.0, color="black", lw=1.0)
    right.plot(time_s, np.minimum(margin_m, 60.0), color=BLUE, label="now [m]")
    window = np.minimum(always(margin_m, 100), 60.0)
    right.plot(time_s, window, color=RED, label="always in the next 5 s [m]")
    for axes in (left, right):
        axes.set(xlabel="time [s]")
        axes.legend(frameon=False)


PICTURES = (drive, rss, monitor)


def main() -> None:
    """Write the pictures."""
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.join("docs", "labs")
    with plt.rc_context(_STYLE):
        for picture in PICTURES:
            figure, axes = plt.subplots(1, 2, figsize=(11.0, 4.2), layout="constrained")
            picture(*axes)
            figure.savefig(os.path.join(folder, f"behaviour_{picture.__name__}.png"))
            plt.close(figure)


if __name__ == "__main__":
    main()
