"""The pictures of docs/labs/imitation.md: a network with and one without pictures off the line.

python3 -m sdc_perception.imitation.plots WITH WITHOUT [FOLDER]
"""

from __future__ import annotations

import os
import sys

import cv2
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.axes import Axes  # noqa: E402

from sdc_perception.imitation.drive import drive  # noqa: E402
from sdc_perception.imitation.record import expert_line  # noqa: E402
from sdc_perception.imitation_network import SteeringNetwork  # noqa: E402
from sdc_perception.imitation_samples import road_view  # noqa: E402
from sdc_sim.camera.renderer import Renderer  # noqa: E402
from sdc_sim.road.random_routes import long_route  # noqa: E402
from sdc_sim.road.road import Road  # noqa: E402

SEED = 2
ROUTE_M = 300.0
START_LEFT_M = 1.0
START_TURNED_RAD = 0.15
GREEN, RED, GREY = "#3a8a4d", "#c2402f", "#999999"
_OFFSETS_M = np.linspace(-1.2, 1.2, 13)
# Places of the route at which the answers are averaged, in rows of 0.05 s.
_PLACES = range(200, 1800, 400)
_STYLE = {"axes.spines.top": False, "axes.spines.right": False, "font.size": 10, "savefig.dpi": 110}


def answers(files: dict[str, str], axes: Axes) -> None:
    """Draw how the curvature of the answers depends on the offset of the car."""
    route_m = long_route(SEED)
    line, renderer = expert_line(route_m), Renderer(Road(route_m))
    views = [
        [road_view(renderer.render(*line.displaced(i, left_m, 0.0))) for left_m in _OFFSETS_M]
        for i in _PLACES
    ]
    right = [[line.answer(i, left_m)[0] for left_m in _OFFSETS_M] for i in _PLACES]
    on_line = np.array([line.answer(i)[0] for i in _PLACES])[:, None]
    axes.plot(
        _OFFSETS_M, np.mean(right - on_line, axis=0), color=GREY, lw=4, label="back to the line"
    )
    for (name, file), colour in zip(files.items(), (GREEN, RED)):
        network = SteeringNetwork.load(file)
        found = np.array([[network.answer(view)[0] for view in row] for row in views]) - on_line
        axes.plot(_OFFSETS_M, found.mean(axis=0), "o-", color=colour, ms=4, label=name)
    axes.axhline(0.0, color="black", lw=0.5)
    axes.set_xlabel("offset of the car, positive left [m]")
    axes.set_ylabel("turn of the answer, positive left [1/m]")
    axes.legend(frameon=False)


def errors(files: dict[str, str], axes: Axes) -> None:
    """Draw the cross-track error over the way of drives that begin beside the line."""
    for (name, file), colour in zip(files.items(), (GREEN, RED)):
        driven = drive(file, long_route(SEED, ROUTE_M), START_LEFT_M, START_TURNED_RAD)
        s_m, cross_track_m = driven.trace["s_m"], driven.trace["cross_track_m"]
        metrics = driven.metrics
        label = f"{name}: {metrics['status']}, {metrics['cross_track_rms_m']:.2f} m RMS"
        axes.plot(s_m, cross_track_m, color=colour, lw=1.2, label=label)
        print(label, flush=True)
    axes.axhspan(-0.75, 0.75, color=GREY, alpha=0.2, label="no wheel on a marking")
    axes.set_ylim(-1.25, 1.25)
    axes.set_xlabel("distance [m]")
    axes.set_ylabel("cross-track error, positive left [m]")
    axes.legend(frameon=False, loc="upper right")


def main() -> None:
    """Draw the pictures."""
    if len(sys.argv) < 3:
        sys.exit("Usage: python3 -m sdc_perception.imitation.plots WITH WITHOUT [FOLDER]")
    folder = sys.argv[3] if len(sys.argv) > 3 else "docs/labs"
    cv2.setNumThreads(1)
    try:
        for path in sys.argv[1:3]:
            SteeringNetwork.load(path)
    except ValueError as error:
        sys.exit(f"plots: {error}")
    files = dict(zip(("with pictures off the line", "without"), sys.argv[1:3]))
    with plt.rc_context(_STYLE):
        for name, draw in (("answers", answers), ("errors", errors)):
            figure, axes = plt.subplots(figsize=(8.0, 3.6), layout="constrained")
            draw(files, axes)
            figure.savefig(os.path.join(folder, f"imitation_{name}.png"))
            plt.close(figure)


if __name__ == "__main__":
    main()
