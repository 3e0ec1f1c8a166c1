"""The text and the tables of the comparison, docs/controllers.md, from the stored peak errors."""

from __future__ import annotations

import json
import math
import textwrap
from typing import Mapping, NamedTuple

from sdc_experiments.snider import methods
from sdc_experiments.snider.courses import lane_change
from sdc_experiments.snider.methods import OWN_METHODS, own_name
from sdc_experiments.snider.study import (
    NEUTRAL,
    PAPER_M,
    SPEEDS_MPS,
    UNDERSTEER,
    UNDERSTEERING,
    Traces,
)
from sdc_sim.physics.vehicle_dynamics import GRAVITY_MPS2

TEXTBOOK, COMPENSATED = map(own_name, OWN_METHODS)
_GEOMETRIC = ("pure pursuit", "Stanley", "kinematic")
_WIDTH = 100


class PeakErrors(NamedTuple):
    """What the page shows of a drive, as in Trace."""

    peak_m: float
    centre_peak_m: float


# By name of the car, name of the course, name of the method, speed [m/s].
Peaks = Mapping[tuple, PeakErrors]


def to_json(traces: Traces) -> str:
    """Return the peak errors of all drives; that of a drive that left the road is null."""
    rows = []
    for key, trace in traces.items():
        errors = (trace.peak_m, trace.centre_peak_m)
        rows.append([*key, *(error if math.isfinite(error) else None for error in errors)])
    return "[\n" + ",\n".join(map(json.dumps, rows)) + "\n]\n"


def from_json(text: str) -> Peaks:
    """Return the peak errors from the result of `to_json`."""
    return {
        tuple(key): PeakErrors(*(math.inf if error is None else error for error in (peak, centre)))
        for *key, peak, centre in json.loads(text)
    }


def metres(value: float) -> str:
    """Return an error [m] as the tables show it; "lost" for a drive that left the road."""
    if not math.isfinite(value):
        return "lost"
    return f"{value:.3f}" if value >= 0.0095 else f"{value:.4f}"


def paper_table(peaks: Peaks, car: str, course: str) -> str:
    """Return the table of a course: the error of each method's point, and that of the paper."""
    rows = _header(course)
    for method, paper in PAPER_M[course].items():
        cells = [
            metres(peaks[car, course, method, speed].peak_m) + (f" ({value:g})" if value else "")
            for speed, value in zip(SPEEDS_MPS, paper)
        ]
        rows.append(f"| {method} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def centre_table(peaks: Peaks, car: str, course: str) -> str:
    """Return the table of a course: the error of the car's centre with every method."""
    rows = _header(course)
    for method in [*PAPER_M["figure-eight"], TEXTBOOK, COMPENSATED]:
        cells = [metres(peaks[car, course, method, speed].centre_peak_m) for speed in SPEEDS_MPS]
        if method == COMPENSATED:
            cells, method = [f"**{cell}**" for cell in cells], f"**{method}**"
        rows.append(f"| {method} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def _header(course: str) -> list[str]:
    return [
        f"| {course} | " + " | ".join(f"{speed:g} m/s" for speed in SPEEDS_MPS) + " |",
        "|---" * (len(SPEEDS_MPS) + 1) + "|",
    ]


def agreement(peaks: Peaks, car: str) -> tuple[list[str], int, float]:
    """Compare the peak errors with those of the paper.

    Returns:
        the cells that differ by more than a factor of two, the number of all cells, and the largest
        factor of the other cells
    """
    beyond, within = [], []
    for course, table in PAPER_M.items():
        for method, paper in table.items():
            for speed, value in zip(SPEEDS_MPS, paper):
                if value:
                    peak = peaks[car, course, method, speed].peak_m
                    factor = max(peak / value, value / peak)
                    if factor > 2.0:
                        beyond.append(f"{method}, {course}, {speed:g} m/s")
                    else:
                        within.append(factor)
    return beyond, len(beyond) + len(within), max(within)


def text(peaks: Peaks) -> str:
    """Return the page, with lines of any length."""
    return "\n\n".join(
        [_introduction(), _paper_section(peaks), _differences(peaks), _own_section(peaks)]
    )


def _introduction() -> str:
    course = lane_change()
    peak = max(abs(course.curvature_at(0.1 * i)) for i in range(1800))
    weights = methods.LQR_WEIGHTS
    pursuit_k = f"k = {methods.PURE_PURSUIT_S:g} s"
    stanley_k = f"k = {methods.STANLEY_PER_S:g} 1/s, the paper's"
    lqr_gain = (
        f"Q = diag({weights['cross_track_weight']:g}, 0, {weights['heading_weight']:g}, 0), R = 1"
    )
    return f"""# A comparison of steering methods

J. M. Snider, *Automatic Steering Methods for Autonomous Automobile Path Tracking* (CMU-RI-TR-09-08,
2009), compares five steering methods on the same courses. The workshop recommends this paper. This
page repeats the comparison with this project's physics and the paper's car
(`config/vehicles/snider2009.yaml`), and adds this project's own methods.

The command `python3 -m sdc_experiments.snider` repeats all drives, stores their peak errors in
`controllers.json`, and writes this page. It uses neither ROS nor a clock, so each run gives the
same numbers.

![Peak error over speed: lines from this project, circles from the paper](controllers_speed.png)

## Courses

![The three courses from above; errors count on the coloured stretches](controllers_courses.png)

- **Lane change**: 3.5 m to the left within 25 m, 25 m straight on, and back. The curvature of each
  change is a sine over 30 m, and 99 % of the lateral motion happens in the middle 25 m. Among
  lengths from 25 to 30 m, this one gives the errors nearest to those of the paper; with 25 m they
  are up to 2.4 times as large at 15 m/s. At 20 m/s the lane change needs
  {peak * SPEEDS_MPS[-1] ** 2:.1f} m/s2, which is all the grip of the tyres. The paper shows no
  errors for this speed.
- **Figure-eight**: circles of 64 m radius, connected by clothoids. Only the second half of each
  circle counts, where the car is in a steady state, as in the paper.
- **Road course**: eight bends of 60 to 200 m radius. The paper's own road is not published, so
  there are no errors to compare with.

## Methods and gains

Each method of the paper controls the point of the car that the paper names, and the error of this
point is measured. It runs 100 times per second and knows the exact road.

| method | point | law | gain |
|---|---|---|---|
| pure pursuit | rear axle | delta = atan(2 L sin(alpha) / (k v)) | {pursuit_k} |
| Stanley | front axle | delta = heading error + atan(k e / v) | {stanley_k} |
| kinematic | rear axle | chained form, three poles at -k | k = {methods.KINEMATIC_PER_M:g} 1/m |
| LQR | centre of gravity | delta = -K x, dynamic bicycle | {lqr_gain} |
| LQR+FF | centre of gravity | the same, with feed-forward of the bend's wheel angle | the same |

Only Stanley's gain is known. Each of the other gains is one value for all courses and speeds,
chosen so that the errors are near those of the paper. The comparison therefore shows that the
*forms* of the methods behave as in the paper, not that the gains are the same."""


def _paper_section(peaks: Peaks) -> str:
    return f"""## Peak errors and those of the paper

Errors are in metres. The errors in brackets are those of the paper, read from its plots.

### The neutral car, with the parameters of the paper

{paper_table(peaks, NEUTRAL, "lane change")}

{paper_table(peaks, NEUTRAL, "figure-eight")}

### The same car with {1e3 * UNDERSTEER:g} mrad/(m/s2) of understeer

{paper_table(peaks, UNDERSTEERING, "lane change")}

{paper_table(peaks, UNDERSTEERING, "figure-eight")}"""


def _differences(peaks: Peaks) -> str:
    beyond, cells, within = agreement(peaks, UNDERSTEERING)
    beyond_neutral, _, within_neutral = agreement(peaks, NEUTRAL)
    degrees_per_g = math.degrees(UNDERSTEER) * GRAVITY_MPS2
    return f"""## Reasons for the differences

With the neutral car, {cells - len(beyond_neutral)} of {cells} cells are within a factor of
{within_neutral:.3g} of the paper. These differ by more than a factor of two:
{"; ".join(beyond_neutral) or "none"}.

On a circle, the neutral car needs exactly the wheel angle that the feed-forward computes, because
both use the same parameters. Almost no error remains. In the paper, an error of millimetres to
centimetres remains, which grows with the square of the speed. This is the error of a car that needs
more wheel angle than its bicycle model predicts. The paper's bicycle model has equal stiffness at
both axles, so it is neutral. Most real cars, and detailed models of them, understeer.

One additional parameter explains the whole figure-eight: {1e3 * UNDERSTEER:g} mrad/(m/s2) of
understeer ({degrees_per_g:.1f} degrees per g), which the car has and the controllers do not know.
Then {cells - len(beyond)} of {cells} cells are within a factor of {within:.3g}. More than a factor
of two: {"; ".join(beyond) or "none"}. At 20 m/s the order from the largest to the smallest error is
that of the paper: pure pursuit, Stanley, kinematic, LQR, LQR+FF. The paper does not state that its
car understeers; this is a conclusion from its errors.

The error of each method grows with the speed v as its law predicts:

- **Pure pursuit** assumes that the car moves in its direction, but at speed the rear tyres slip. On
  a circle e = k v (slip of the rear axle). The slip grows with v^2, so e grows with v^3.
- **Stanley** has no term for the slip of the front tyres: e = v slip / k, which also grows with
  v^3.
- **Kinematic** has no slip in its model: e = 3 slip / k, which grows with v^2. In the lane change
  this method loses the road first, because its gains do not depend on the speed.
- **LQR** without feed-forward needs an error to steer in a bend, even at low speed. It is the worst
  method at low speed and a good one at high speed.
- **LQR+FF** is as good as its model of the car."""


def _own_section(peaks: Peaks) -> str:
    tables = {
        car: "\n\n".join(
            centre_table(peaks, car, course)
            for course in ("lane change", "figure-eight", "road course")
        )
        for car in (NEUTRAL, UNDERSTEERING)
    }
    lane_change_factors, figure_eight_factors = (
        ", ".join(f"{_factor(peaks, course, speed):.1f}" for speed in SPEEDS_MPS)
        for course in PAPER_M
    )
    return f"""## This project's methods on the same courses

These tables show the error of the car's *centre*, which is what the referee measures. The car is
the same. The methods of the paper run 100 times per second on the exact road, and LQR also knows
the lateral speed, which no sensor of this project measures. This project's methods run as in the
stack: 20 times per second, on points 1 m apart, with the parameters of
`config/simple_controller.yaml`. Like the others, they know the parameters of the neutral car.

- `stanley` is the textbook law of the paper, as the students write it. Its gain is k = 2.5 1/s,
  with 2 m/s of softening.
- `stanley_compensated` is the default of this project: the same law and gain with three
  compensations.

![The double lane change at 15 m/s](controllers_lane_change.png)

### The neutral car

{tables[NEUTRAL]}

### The car with understeer that no controller knows

{tables[UNDERSTEERING]}

With understeer, the peak error of `stanley_compensated` is smaller than that of the best geometric
method of the paper by a factor of {lane_change_factors} (lane change at 5, 10, 15, 20 m/s) and
{figure_eight_factors} (figure-eight). Three compensations make the difference to `stanley`: the
front axle follows *its own* path instead of that of the centre, the slip of the tyres in the bend
is fed forward at both axles, and the pose is predicted over the delay of a command. LQR with
feed-forward, with an exact model and the full state, is better in some cells. In the stack this
controller is `lqr_feedforward`.
"""


def _factor(peaks: Peaks, course: str, speed: float) -> float:
    """Return the error of the best geometric method of the paper over that of the default."""
    best = min(peaks[UNDERSTEERING, course, name, speed].centre_peak_m for name in _GEOMETRIC)
    return best / peaks[UNDERSTEERING, course, COMPENSATED, speed].centre_peak_m


def reflowed(markdown: str) -> str:
    """Return the same text with paragraphs and list items filled to the width of a line."""
    paragraphs = []
    for paragraph in markdown.split("\n\n"):
        if paragraph.lstrip().startswith("- "):
            items = ("\n" + paragraph.strip()).split("\n- ")[1:]
            paragraph = "\n".join(_filled("- " + item, indent="  ") for item in items)
        elif not paragraph.lstrip().startswith(("|", "#", "!")):
            paragraph = _filled(paragraph)
        paragraphs.append(paragraph.strip())
    return "\n\n".join(paragraphs) + "\n"


def _filled(paragraph: str, indent: str = "") -> str:
    return textwrap.fill(
        " ".join(paragraph.split()),
        _WIDTH,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
