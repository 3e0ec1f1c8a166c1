"""Draw the pictures of the guide and of its mathematics with the car's own library.

In the project's environment: python3 -m sdc_workshop.pictures [FOLDER]
"""

from __future__ import annotations

import math
import os
import sys
from pathlib import Path

import cv2
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, FancyBboxPatch

from sdc_common.geometry.angles import wrap_angle
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds
from sdc_package.pid import Pid, PidGains
from sdc_package.steering.stanley import stanley_angle
from sdc_package.waypoint_search import WaypointSearch
from sdc_sim.camera.renderer import Renderer
from sdc_sim.road.road import Road
from sdc_workshop.drawing import (
    AXLE_M,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    draw_arrow,
    draw_car,
    hide_frame,
    new_figure,
)
from sdc_workshop.workspace import SOLUTION

FOLDER = Path(__file__).resolve().parents[1] / "pictures"
WHEELBASE_M = 2.87


def architecture() -> Figure:
    """Draw the nodes of the finished car and the topics between them."""
    figure, (axes,) = new_figure(10.0, 3.9)
    boxes = {
        "mission_planner": (0.0, 2.0),
        "local_planner": (3.6, 2.0),
        "simple_controller": (7.2, 2.0),
        "the world\n(sim or CARLA)": (7.2, 0.0),
        "camera": (3.6, 0.0),
        "waypoints.csv": (0.0, 3.3),
    }
    for name, (x, y) in boxes.items():
        mine = not name.startswith(("the world", "waypoints"))
        axes.add_patch(
            FancyBboxPatch(
                (x - 0.85, y - 0.3),
                1.7,
                0.6,
                boxstyle="round,pad=0.06",
                facecolor=BLUE if mine else "#eeeeee",
                alpha=0.9,
                edgecolor=GREY,
            )
        )
        axes.text(
            x, y, name, ha="center", va="center", color="white" if mine else "black", fontsize=10
        )
    for start, end, text, offset in (
        ((0.0, 2.95), (0.0, 2.4), "", (0, 0)),
        ((0.95, 2.0), (2.65, 2.0), "/planner/\nmission_waypoints", (0, 0.34)),
        ((4.55, 2.0), (6.25, 2.0), "/planner/\nlocal_waypoints", (0, 0.34)),
        ((7.6, 1.6), (7.6, 0.42), "throttle, brake, steer\n.../vehicle_control_cmd", (1.15, 0)),
        ((6.8, 0.42), (6.8, 1.6), "", (0, 0)),
        ((6.3, 0.42), (4.0, 1.6), "odometry\n.../odometry", (-0.2, -0.28)),
        ((6.25, 0.0), (4.55, 0.0), "pictures\n.../image_color", (0, -0.36)),
        ((2.65, 0.0), (1.4, 0.0), "", (0, 0)),
    ):
        draw_arrow(axes, start, end, GREY, text, offset)
    axes.text(1.3, 0.0, "/camera/lane_mask", ha="right", va="center", color=GREY, fontsize=11)
    axes.text(
        -0.85,
        -0.75,
        "blue: your nodes; arrows: topics; ... is /carla/ego_vehicle",
        color=GREY,
        fontsize=9,
    )
    axes.set_xlim(-1.0, 9.6)
    axes.set_ylim(-0.95, 3.75)
    axes.set_axis_off()
    return figure


def stanley() -> Figure:
    """Draw heading error, cross-track error and wheel angle, and the way back to the path."""
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(11.0, 4.2), gridspec_kw={"width_ratios": [1.0, 1.1]}
    )
    _stanley_angles(left)
    _stanley_responses(right)
    return figure


def _stanley_angles(axes: Axes) -> None:
    yaw, heading = math.radians(22.0), math.radians(4.0)
    x, y = 1.0, 1.9
    front_x, front_y = x + AXLE_M * math.cos(yaw), y + AXLE_M * math.sin(yaw)
    along = front_x * math.cos(heading) + front_y * math.sin(heading)
    foot = (along * math.cos(heading), along * math.sin(heading))
    error = math.hypot(front_x - foot[0], front_y - foot[1])
    wheel = stanley_angle(heading - yaw, error, 5.0, 2.5, 2.0)
    axes.plot([-3.0, 9.0], [-3.0 * math.tan(heading), 9.0 * math.tan(heading)], color=GREEN, lw=2.5)
    axes.text(7.6, 7.6 * math.tan(heading) - 0.55, "path", color=GREEN, fontsize=12)
    draw_car(axes, x, y, yaw, wheel)
    for angle, colour in ((yaw, BLUE), (heading, GREEN)):
        end = front_x + 4.6 * math.cos(angle), front_y + 4.6 * math.sin(angle)
        axes.plot([front_x, end[0]], [front_y, end[1]], color=colour, ls="--", lw=1.2)
    axes.text(
        front_x + 4.3 * math.cos(yaw),
        front_y + 4.3 * math.sin(yaw) + 0.3,
        "heading of the car",
        color=BLUE,
        ha="right",
        fontsize=10,
    )
    axes.add_patch(
        Arc(
            (front_x, front_y),
            6.4,
            6.4,
            theta1=math.degrees(heading),
            theta2=math.degrees(yaw),
            color=ORANGE,
            lw=2,
        )
    )
    axes.text(front_x + 3.35, front_y + 0.8, r"heading error $\psi$", color=ORANGE, fontsize=11)
    axes.plot([foot[0], front_x], [foot[1], front_y], color=RED, lw=2)
    axes.annotate(
        "cross-track error $e$\n(left of the path: positive)",
        (0.5 * (foot[0] + front_x), foot[1] + 0.35),
        (-1.6, -1.0),
        color=RED,
        fontsize=10,
        va="center",
        arrowprops={"arrowstyle": "-", "color": RED, "lw": 0.8},
    )
    tip = (front_x + 2.6 * math.cos(yaw + wheel), front_y + 2.6 * math.sin(yaw + wheel))
    draw_arrow(axes, (front_x, front_y), tip, "#333333")
    axes.text(tip[0] + 0.1, tip[1] - 0.25, r"wheels: $\delta$", color="#333333", fontsize=11)
    axes.set_xlim(-2.2, 9.2)
    axes.set_ylim(-1.6, 5.0)
    hide_frame(axes)


def _stanley_responses(axes: Axes) -> None:
    for k, colour in ((0.5, ORANGE), (2.5, BLUE), (10.0, RED)):
        axes.plot(*_driven(k), color=colour, label=f"k = {k} 1/s")
    axes.axhline(0.0, color=GREEN, lw=2.5)
    axes.set_xlabel("along the path, m")
    axes.set_ylabel("front axle, m to the left of the path")
    axes.set_title("5 m/s, starting 2 m off the path; the wheels lag by 0.2 s", fontsize=10)
    axes.legend(frameon=False)


def _driven(k: float, speed: float = 5.0, lag_s: float = 0.2, tick_s: float = 0.01) -> np.ndarray:
    """Return x, y of the front axle of a bicycle model that Stanley steers to the x axis [m]."""
    x, y, yaw, wheel = 0.0, 2.0, 0.0, 0.0
    points = []
    while x < 30.0:
        front = y + WHEELBASE_M * math.sin(yaw)
        points.append((x + WHEELBASE_M * math.cos(yaw), front))
        wanted = min(max(stanley_angle(wrap_angle(-yaw), front, speed, k, 2.0), -0.8), 0.8)
        wheel += (wanted - wheel) * tick_s / lag_s
        x, y = x + speed * math.cos(yaw) * tick_s, y + speed * math.sin(yaw) * tick_s
        yaw += speed / WHEELBASE_M * math.tan(wheel) * tick_s
    return np.array(points).T


def cross_track() -> Figure:
    """Draw the sign of the cross-track error, and where the car steers."""
    figure, (axes,) = new_figure(8.5, 3.3)
    axes.annotate(
        "",
        xy=(11.5, 0.0),
        xytext=(-3.0, 0.0),
        arrowprops={"arrowstyle": "-|>", "color": GREEN, "lw": 2.5},
    )
    axes.text(10.2, 0.25, "path", color=GREEN, fontsize=12)
    for x, side, colour, text in (
        (0.0, 1.0, RED, "$e > 0$: left of the path\nsteers right: $\\delta < 0$"),
        (6.0, -1.0, BLUE, "$e < 0$: right of the path\nsteers left: $\\delta > 0$"),
    ):
        wheel = stanley_angle(0.0, side * 1.8, 5.0, 2.5, 2.0)
        place = draw_car(axes, x, side * 1.8, 0.0, wheel, colour)
        front = place(AXLE_M)
        axes.plot([front[0], front[0]], [0.0, front[1]], color=colour, lw=2, ls=":")
        draw_arrow(
            axes,
            front,
            (front[0] + 2.2 * math.cos(wheel), front[1] + 2.2 * math.sin(wheel)),
            "#333333",
        )
        axes.text(x - 0.2, side * 3.4, text, color=colour, ha="center", va="center", fontsize=11)
    axes.set_xlim(-3.2, 12.0)
    axes.set_ylim(-4.1, 4.1)
    hide_frame(axes)
    return figure


def dot_product() -> Figure:
    """Draw a waypoint ahead of the car, and one behind it."""
    figure, pair = new_figure(10.0, 2.9, 2)
    turned = np.arange(-0.4, 0.8, 0.2)
    points = np.column_stack([30.0 * np.sin(turned), 30.0 * (1.0 - np.cos(turned))])
    search = WaypointSearch(points)
    for axes, s in zip(pair, (0.11, 0.27)):
        x, y = 28.8 * math.sin(s), 30.0 - 28.8 * math.cos(s)
        index = search.nearest(x, y)
        behind = search.is_behind(index, x, y)
        axes.plot(*points.T, "o-", color=GREEN, ms=7)
        for number, point in enumerate(points):
            axes.text(
                point[0] + 0.2, point[1] - 1.3, str(number), color=GREEN, fontsize=10, clip_on=True
            )
        draw_car(axes, x, y, s)
        along = points[index + 1] - points[index - 1]
        axes.plot(*points[index], "o", color=RED, ms=9)
        draw_arrow(axes, tuple(points[index]), tuple(points[index] + 0.7 * along), ORANGE)
        draw_arrow(axes, (x, y), tuple(points[index]), RED)
        sign = "< 0: behind, use the next" if behind else "> 0: ahead, use it"
        axes.set_title(
            f"nearest: {index};  red . orange {sign}", fontsize=11, color=RED if behind else "black"
        )
        axes.set_xlim(-8.0, 15.0)
        axes.set_ylim(-2.8, 5.6)
        hide_frame(axes)
    figure.text(
        0.5,
        0.02,
        "red: from the car to its nearest waypoint;  orange: direction of the route there",
        ha="center",
        fontsize=10,
        color=GREY,
    )
    return figure


def quaternion() -> Figure:
    """Draw yaw, and the quaternion of a rotation about the vertical axis."""
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(10.0, 3.8), gridspec_kw={"width_ratios": [1.0, 1.3]}
    )
    yaw = math.radians(50.0)
    draw_arrow(left, (0.0, 0.0), (4.5, 0.0), GREY)
    draw_arrow(left, (0.0, 0.0), (0.0, 4.5), GREY)
    left.text(4.55, -0.35, "x", color=GREY, fontsize=12)
    left.text(-0.4, 4.4, "y", color=GREY, fontsize=12)
    draw_car(left, 0.0, 0.0, yaw)
    draw_arrow(left, (0.0, 0.0), (4.2 * math.cos(yaw), 4.2 * math.sin(yaw)), BLUE)
    left.add_patch(
        Arc((0.0, 0.0), 6.4, 6.4, theta1=0.0, theta2=math.degrees(yaw), color=ORANGE, lw=2)
    )
    left.text(
        3.3 * math.cos(0.5 * yaw), 3.3 * math.sin(0.5 * yaw), "yaw", color=ORANGE, fontsize=13
    )
    left.set_xlim(-2.6, 5.0)
    left.set_ylim(-2.4, 4.8)
    hide_frame(left)
    angles = np.linspace(-math.pi, math.pi, 400)
    right.plot(angles, np.cos(0.5 * angles), color=BLUE, label="w = cos(yaw / 2)")
    right.plot(angles, np.sin(0.5 * angles), color=RED, label="z = sin(yaw / 2)")
    right.axvline(yaw, color=ORANGE, lw=1.5, ls="--")
    right.set_xticks(
        [-math.pi, -0.5 * math.pi, 0.0, 0.5 * math.pi, math.pi], ["-pi", "-pi/2", "0", "pi/2", "pi"]
    )
    right.set_xlabel("yaw, radians")
    right.set_title("on a flat road x = y = 0; z and w remain", fontsize=10)
    right.legend(frameon=False)
    return figure


def pid() -> Figure:
    """Draw the speed of a car in a headwind, with P, PI and too much I."""
    figure, (axes,) = new_figure(8.0, 3.8)
    for gains, colour, name in (
        (PidGains(1.2), ORANGE, "P: kp 1.2"),
        (PidGains(1.2, 0.3), BLUE, "PI: kp 1.2, ki 0.3 (this car)"),
        (PidGains(1.2, 3.0), RED, "too much I: ki 3.0"),
        (PidGains(0.3), GREY, "too little P: kp 0.3"),
    ):
        controller = Pid(gains, -7.0, 2.0)
        speed, acceleration, times, speeds = 6.0, 0.0, np.arange(0.0, 20.0, 0.05), []
        for _ in times:
            speeds.append(speed)
            wanted, _ = controller.update(10.0, speed, 0.05)
            acceleration += (wanted - acceleration) * 0.05 / 0.3
            speed += (acceleration - 0.6) * 0.05
        axes.plot(times, speeds, color=colour, label=name)
    axes.axhline(10.0, color=GREEN, lw=1.5, ls="--")
    axes.set_xlabel("s")
    axes.set_ylabel("speed, m/s")
    axes.set_title(
        "from 6 to 10 m/s against a headwind of 0.6 m/s$^2$; the pedals lag by 0.3 s", fontsize=10
    )
    axes.legend(frameon=False, loc="lower right")
    return figure


def lane_filter() -> Figure:
    """Draw a camera picture, and its mask."""
    route = load_waypoints(str(SOLUTION / "sdc_common" / "data" / "waypoints.csv"))
    picture = Renderer(Road(route)).render(42.0, 0.0, 0.0)
    mask = LaneFilter(
        LaneFilterThresholds(gradient=70, saturation=90, lightness=110, horizon_fraction=0.52)
    ).mask(picture)
    figure, pair = new_figure(10.0, 4.2, 2)
    shown = cv2.cvtColor(picture, cv2.COLOR_BGRA2RGB)
    for axes, image, title in (
        (pair[0], shown, "the camera's picture"),
        (pair[1], mask, "the lane mask"),
    ):
        axes.imshow(image, cmap="gray")
        axes.set_title(title, fontsize=11)
        axes.set_axis_off()
    return figure


PICTURES = (architecture, stanley, cross_track, dot_product, quaternion, pid, lane_filter)


def main(folder: Path = FOLDER) -> None:
    """Write all pictures to a folder."""
    os.makedirs(folder, exist_ok=True)
    plt.rcParams.update({"font.size": 10, "axes.spines.top": False, "axes.spines.right": False})
    for draw in PICTURES:
        figure = draw()
        figure.tight_layout()
        figure.savefig(folder / f"{draw.__name__}.png", dpi=90, metadata={"Software": None})
        plt.close(figure)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
