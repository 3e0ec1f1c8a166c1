"""Draw cars, arrows and axes with matplotlib, for the pictures of the guide."""

from __future__ import annotations

import math
from typing import Callable, Sequence

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

BLUE, RED, GREEN, GREY, ORANGE = "#2a6fb0", "#c2402f", "#3a8a4d", "#666666", "#d98c1f"
AXLE_M = 1.435


def new_figure(width: float, height: float, columns: int = 1) -> tuple[Figure, Sequence[Axes]]:
    """Return a figure of this size [inch] and its axes, one for each column."""
    figure, axes = plt.subplots(1, columns, figsize=(width, height), squeeze=False)
    return figure, axes[0]


def hide_frame(axes: Axes) -> None:
    """Hide frame and ticks, and use one scale for both axes."""
    axes.set_aspect("equal")
    axes.set_axis_off()


def draw_arrow(
    axes: Axes,
    start: tuple,
    end: tuple,
    colour: str,
    text: str = "",
    offset: tuple = (0.0, 0.0),
) -> None:
    """Draw an arrow, with a text at an offset from its middle."""
    axes.annotate(
        "",
        xy=end,
        xytext=start,
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 2.0, "shrinkA": 0, "shrinkB": 0},
    )
    if text:
        middle = 0.5 * (np.add(start, end)) + offset
        axes.text(*middle, text, color=colour, ha="center", va="center", fontsize=11)


def draw_car(
    axes: Axes, x: float, y: float, yaw: float, wheel: float = 0.0, colour: str = BLUE
) -> Callable[..., tuple]:
    """Draw a car from above.

    Args:
        axes: where to draw
        x: position of its centre [m]
        y: position of its centre [m]
        yaw: heading [rad]
        wheel: front wheel angle, positive left [rad]
        colour: colour of the body

    Returns:
        a function that converts a distance ahead of the centre, and one to the left, to (x, y)
    """
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    body = np.array([[-2.35, -0.95], [2.35, -0.95], [2.35, 0.95], [-2.35, 0.95]]) @ turn.T + (x, y)
    axes.add_patch(
        Polygon(body, closed=True, facecolor=colour, alpha=0.15, edgecolor=colour, lw=1.5)
    )
    for along, across, angle in (
        (-AXLE_M, -0.8, 0.0),
        (-AXLE_M, 0.8, 0.0),
        (AXLE_M, -0.8, wheel),
        (AXLE_M, 0.8, wheel),
    ):
        spin = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        tyre = np.array([[-0.35, -0.12], [0.35, -0.12], [0.35, 0.12], [-0.35, 0.12]]) @ spin.T + (
            along,
            across,
        )
        axes.add_patch(Polygon(tyre @ turn.T + (x, y), closed=True, facecolor="#333333"))
    return lambda along, across=0.0: tuple(turn @ (along, across) + (x, y))
