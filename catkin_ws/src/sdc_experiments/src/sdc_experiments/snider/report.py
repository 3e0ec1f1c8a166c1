"""Writes controllers.md and its pictures: the paper's comparison of steering methods, driven again by `snider`."""

from __future__ import annotations

import math
import os
import sys
import textwrap

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from sdc_experiments import snider  # noqa: E402
from sdc_experiments.snider import PAPER_M, SPEEDS_MPS  # noqa: E402
from sdc_sim.physics.vehicle import GRAVITY_MPS2  # noqa: E402

NEUTRAL, UNDERSTEERING = "neutral", "understeering"
OURS = "this project"
COLOURS = {
    "pure pursuit": "#d95f02",
    "Stanley": "#1b9e77",
    "kinematic": "#7570b3",
    "LQR": "#c2a000",
    "LQR+FF": "#e7298a",
    OURS: "#111111",
}
_WIDTH = 138
_WHOLE_WORDS = {"break_long_words": False, "break_on_hyphens": False}
_STYLE = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "figure.dpi": 100,
    "savefig.dpi": 130,
    "svg.hashsalt": "sdc",
}


def metres(value: float) -> str:
    """An error as the tables have it; a drive that left the road is said to be lost."""
    if not math.isfinite(value):
        return "lost"
    return f"{value:.3f}" if value >= 0.0095 else f"{value:.4f}"


def beside_the_paper(traces, car: str, course: str) -> str:
    """A table of one course: each method's peak error at its own point, the paper's in brackets."""
    rows = [
        "| " + course + " | " + " | ".join(f"{speed:g} m/s" for speed in SPEEDS_MPS) + " |",
        "|---" * (len(SPEEDS_MPS) + 1) + "|",
    ]
    for method, paper in PAPER_M[course].items():
        cells = [
            metres(traces[car, course, method, speed].peak_m) + (f" ({value:g})" if value else "")
            for speed, value in zip(SPEEDS_MPS, paper)
        ]
        rows.append(f"| {method} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def at_the_centre(traces, car: str, course: str) -> str:
    """A table of one course: the centre's peak error under every method, and this project's default."""
    names = [*PAPER_M["figure-eight"], OURS]
    rows = [
        "| " + course + " | " + " | ".join(f"{speed:g} m/s" for speed in SPEEDS_MPS) + " |",
        "|---" * (len(SPEEDS_MPS) + 1) + "|",
    ]
    for method in names:
        cells = [metres(traces[car, course, method, speed].centre_peak_m) for speed in SPEEDS_MPS]
        if method == OURS:
            cells, method = [f"**{cell}**" for cell in cells], f"**{method}**"
        rows.append(f"| {method} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def farthest(traces, car: str):
    """(cells beyond a factor of two, all cells, largest factor within): how the peak errors compare with the paper's."""
    beyond, within = [], []
    for course, table in PAPER_M.items():
        for method, paper in table.items():
            for speed, value in zip(SPEEDS_MPS, paper):
                if value:
                    peak = traces[car, course, method, speed].peak_m
                    factor = max(peak / value, value / peak)
                    (beyond if factor > 2.0 else within).append(
                        (factor, f"{method}, {course}, {speed:g} m/s")
                    )
    return beyond, len(beyond) + len(within), max(within)[0]


def draw_courses(courses, path):
    """The three courses from above."""
    figure, axes = plt.subplots(
        1, 3, figsize=(12.0, 3.6), gridspec_kw={"width_ratios": (1.5, 1.0, 1.3)}
    )
    for axis, course in zip(axes, courses):
        axis.plot(course.x, course.y, color="#333333", linewidth=2.0)
        for start, end in course.measured:
            part = slice(int(start / 0.05), int(end / 0.05))
            axis.plot(
                course.x[part],
                course.y[part],
                color=COLOURS["Stanley"],
                linewidth=4.0,
                alpha=0.55,
                solid_capstyle="butt",
            )
        axis.plot(course.x[0], course.y[0], "o", color=COLOURS["pure pursuit"])
        if course.name == "lane change":
            axis.set_ylim(-3.0, 6.5)
        else:
            axis.set_aspect("equal", adjustable="datalim")
        axis.set_title(f"{course.name}, {course.length_m:.0f} m")
        axis.set_xlabel("x [m]")
    axes[0].set_ylabel("y [m]")
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)


def draw_speeds(traces, path):
    """Peak error over speed, the paper's points beside."""
    figure, axes = plt.subplots(1, 2, figsize=(12.0, 5.4), sharey=True)
    for axis, course in zip(axes, PAPER_M):
        for method, paper in PAPER_M[course].items():
            colour = COLOURS[method]
            peaks = [traces[UNDERSTEERING, course, method, speed].peak_m for speed in SPEEDS_MPS]
            axis.plot(
                SPEEDS_MPS,
                [peak if peak < 1.5 else math.nan for peak in peaks],
                color=colour,
                linewidth=2.0,
                label=method,
            )
            known = [(speed, value) for speed, value in zip(SPEEDS_MPS, paper) if value]
            axis.plot(
                *zip(*known),
                "o",
                markersize=9,
                markerfacecolor="white",
                markeredgewidth=2.0,
                color=colour,
            )
        axis.plot(
            SPEEDS_MPS,
            [traces[UNDERSTEERING, course, OURS, speed].centre_peak_m for speed in SPEEDS_MPS],
            color=COLOURS[OURS],
            linewidth=2.0,
            linestyle="--",
            label=f"{OURS}, at the centre",
        )
        axis.plot(
            [],
            [],
            "o",
            markersize=9,
            markerfacecolor="white",
            markeredgewidth=2.0,
            color="#777777",
            label="the paper, from its plots",
        )
        axis.set_yscale("log")
        axis.set_ylim(0.0008, 1.5)
        axis.set_yticks([0.001, 0.01, 0.1, 1.0])
        axis.set_yticklabels(["1 mm", "1 cm", "10 cm", "1 m"])
        axis.set_xticks(SPEEDS_MPS)
        axis.set_xlabel("speed [m/s]")
        axis.set_title(course)
    axes[0].set_ylabel("peak cross-track error")
    axes[1].legend(loc="lower right", fontsize=9, framealpha=0.95)
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)


def draw_lane_change(traces, course, speed, path):
    """The centre's way through the lane change, and its error, under every method."""
    figure, (above, below) = plt.subplots(2, 1, figsize=(12.0, 6.4), sharex=True)
    above.plot(
        course.x,
        course.y,
        color="#bbbbbb",
        linewidth=7.0,
        label="the course",
        solid_capstyle="butt",
    )
    for method, colour in COLOURS.items():
        trace = traces[UNDERSTEERING, course.name, method, speed]
        width = 2.4 if method == OURS else 1.6
        above.plot(*trace.xy_m.T, color=colour, linewidth=width, label=method)
        below.plot(trace.xy_m[:, 0], trace.centre_error_m, color=colour, linewidth=width)
    above.set_ylabel("y [m]")
    above.set_title(f"double lane change at {speed:g} m/s, the car's centre")
    above.legend(fontsize=9, loc="lower center", bbox_to_anchor=(0.41, 0.02))
    below.set_ylabel("cross-track error [m], left +")
    below.set_xlabel("x [m]")
    below.set_xlim(15.0, 160.0)
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)


def text(traces) -> str:
    """controllers.md."""
    beyond, cells, within = farthest(traces, UNDERSTEERING)
    beyond_neutral, _, within_neutral = farthest(traces, NEUTRAL)
    listed = "; ".join(name for _, name in beyond_neutral) or "none"
    still = "; ".join(name for _, name in beyond) or "none"
    ratios = {
        course: [
            min(
                traces[UNDERSTEERING, course, name, speed].centre_peak_m
                for name in ("pure pursuit", "Stanley", "kinematic")
            )
            / traces[UNDERSTEERING, course, OURS, speed].centre_peak_m
            for speed in SPEEDS_MPS
        ]
        for course in PAPER_M
    }
    lane_change_ratios, figure_eight_ratios = (
        ", ".join(f"{value:.1f}" for value in values) for values in ratios.values()
    )
    steepest = max(snider.lane_change().curvature)
    degrees_a_g = math.degrees(snider.UNDERSTEER) * GRAVITY_MPS2
    weights = snider.LQR_WEIGHTS
    lqr_gain = (
        f"Q = diag({weights['cross_track_weight']:g}, 0, {weights['heading_weight']:g}, 0), R = 1"
    )
    return f"""# The classic controllers side by side

J. M. Snider, *Automatic Steering Methods for Autonomous Automobile Path Tracking* (CMU-RI-TR-09-08, 2009), the paper that the workshop
recommends, drives five
steering methods around the same courses. This is its comparison with this project's physics and the paper's car
(`config/vehicles/snider2009.yaml`), and beside
it what the project's default does. `python3 -m sdc_experiments.snider` drives it all again and writes this file: no ROS, no clock, the same
figures in every run.

![Peak error over speed: lines from this project, circles from the paper](controllers_speed.png)

## Courses

![The three courses from above; errors count on the coloured stretches](controllers_courses.png)

- **Lane change**: 3.5 m to the left over 25 m, 25 m on, and back. Each change is a sine of curvature over 30 m, of which the middle 25
  m hold 99 % of the way
  to the side. Of lengths from 25 to 30 m it is the one that comes nearest to the paper's errors; over 25 m they are up to
  2.4 times as large at 15 m/s. At 20 m/s it asks for {steepest * SPEEDS_MPS[-1] ** 2:.1f} m/s2,
  all the grip there is; the paper shows no errors there.
- **Figure-eight**: 64 m radius, clothoids in between. Only the settled second half of each circle counts, as in the paper's steady state.
- **Road course**: eight bends of 60 to 200 m radius. The paper's own road was not at hand, so its errors cannot stand beside.

## Methods and gains

Each method steers and is measured at the paper's point of the car, 100 times a second, and knows the exact road.

| method | point | law | gain |
|---|---|---|---|
| pure pursuit | rear axle | delta = atan(2 L sin(alpha) / (k v)) | k = {snider.PURE_PURSUIT_S:g} s |
| Stanley | front axle | delta = heading error + atan(k e / v) | k = {snider.STANLEY_PER_S:g} 1/s, the paper's |
| kinematic | rear axle | chained form, three poles at -k | k = {snider.KINEMATIC_PER_M:g} 1/m |
| LQR | centre of gravity | delta = -K x, dynamic bicycle | {lqr_gain} |
| LQR+FF | centre of gravity | the same with the bend's wheel angle fed forward | the same |

Only Stanley's gain is known here. Each of the others is one value for all courses and speeds, chosen so that the errors come near the
paper's: the figures
show that the *forms* behave as the paper says, not that the gains are the paper's.

## Peak errors beside the paper's

Metres; in brackets the paper's, read from its plots.

### The car as its figures say: neutral

{beside_the_paper(traces, NEUTRAL, "lane change")}

{beside_the_paper(traces, NEUTRAL, "figure-eight")}

### The same car with {1e3 * snider.UNDERSTEER:g} mrad/(m/s2) of understeer

{beside_the_paper(traces, UNDERSTEERING, "lane change")}

{beside_the_paper(traces, UNDERSTEERING, "figure-eight")}

## Why they differ

Of {cells} cells, {cells - len(beyond_neutral)} of the neutral car lie within a factor of {within_neutral:.3g} of the paper's. Beyond a
factor of two: {listed}.

On a circle the neutral car needs exactly the wheel angle that the feed-forward computes from the same figures, and keeps hardly any
error;
the paper's keeps millimetres to centimetres, growing with the square of the speed. That is what a car leaves that needs more wheel angle
than its bicycle model knows. The paper's bicycle has equal stiffness at both axles: neutral. Most real cars, and detailed models of
them, understeer.
With one more figure, {1e3 * snider.UNDERSTEER:g} mrad/(m/s2) of understeer ({degrees_a_g:.1f} degrees a g) in the car
and not in the controllers, the whole figure-eight falls into place: {cells - len(beyond)} of {cells} cells lie within a factor of
{within:.3g}, beyond two: {still}.
At 20 m/s the order from worst to best is then the paper's: pure pursuit, Stanley, kinematic, LQR, LQR+FF.
That the paper's car understeers is inferred from its errors here, not read in it.

What each method's error says, and it grows as it should:

- **Pure pursuit** aims where its nose points, but at speed the rear tyres slip: on a circle e = k v (slip of the rear axle), with slip
  as v^2, so that e grows with v^3.
- **Stanley** has no term for the front tyres' slip: e = v slip / k, again v^3.
- **Kinematic**: no slip in its model; e = 3 slip / k, and grows with v^2. In the lane change it is the first to lose its way,
  as its gains know no speed.
- **LQR** without feed-forward needs an error to steer a bend at all, even at walking pace: worst when slow, good when fast.
- **LQR+FF** is as good as its model of the car.

## This project's default on the same courses

The same car, now the *centre's* error, which is what the referee measures. The paper's methods run 100 times a second and are given the
exact road (LQR is also given
the sideways speed, which no sensor here measures); the default, `stanley` with the figures of `config/simple_controller.yaml`, runs as
in the stack, 20 times a second on
points 1 m apart. It knows the neutral car's figures, as the others do.

![The double lane change at 15 m/s](controllers_lane_change.png)

### Neutral car

{at_the_centre(traces, NEUTRAL, "lane change")}

{at_the_centre(traces, NEUTRAL, "figure-eight")}

{at_the_centre(traces, NEUTRAL, "road course")}

### With the understeer that nobody was told of

{at_the_centre(traces, UNDERSTEERING, "lane change")}

{at_the_centre(traces, UNDERSTEERING, "figure-eight")}

{at_the_centre(traces, UNDERSTEERING, "road course")}

With the understeer its peak error is smaller than that of the best geometric method of the paper by a factor of
{lane_change_ratios} (lane change at 5, 10, 15, 20 m/s) and {figure_eight_ratios} (figure-eight). What makes the difference from the
paper's
Stanley: the front axle follows *its own* path, not the centre's; the tyres' slip in the bend is fed forward at both axles; the pose is
predicted over the time that a command holds.
LQR with feed-forward, exact model and full state is better still in places; `lqr_feedforward` is that controller in the stack.
"""


def reflowed(markdown: str) -> str:
    """The same text with the lines of its paragraphs filled: figures of any length stand in them."""
    paragraphs = []
    for paragraph in markdown.split("\n\n"):
        if paragraph.lstrip().startswith("- "):
            items = [
                " ".join(item.split()) for item in ("\n" + paragraph.strip()).split("\n- ")[1:]
            ]
            paragraph = "\n".join(
                textwrap.fill("- " + item, _WIDTH, subsequent_indent="  ", **_WHOLE_WORDS)
                for item in items
            )
        elif not paragraph.lstrip().startswith(("|", "#", "!")):
            paragraph = textwrap.fill(" ".join(paragraph.split()), _WIDTH, **_WHOLE_WORDS)
        paragraphs.append(paragraph.strip())
    return "\n\n".join(paragraphs) + "\n"


def main() -> None:
    """Drive everything, write controllers.md and its pictures into the folder that the command line names."""
    folder = (
        sys.argv[1]
        if len(sys.argv) > 1
        else os.path.join(os.path.dirname(os.path.abspath(__file__)), *[".."] * 5, "docs")
    )
    if not os.path.isdir(folder):
        sys.exit(
            f"snider: there is no folder {folder}; name one: python3 -m sdc_experiments.snider FOLDER"
        )
    car, _ = snider.snider_car()
    courses = snider.lane_change(), snider.figure_eight(), snider.road_course()
    traces = snider.all_drives({NEUTRAL: car, UNDERSTEERING: snider.understeering(car)}, courses)
    with plt.rc_context(_STYLE):
        draw_courses(courses, os.path.join(folder, "controllers_courses.png"))
        draw_speeds(traces, os.path.join(folder, "controllers_speed.png"))
        draw_lane_change(
            traces, courses[0], 15.0, os.path.join(folder, "controllers_lane_change.png")
        )
    path = os.path.normpath(os.path.join(folder, "controllers.md"))
    with open(path, "w", encoding="utf-8") as file:
        file.write(reflowed(text(traces)))
    print(f"snider: wrote {path}")
