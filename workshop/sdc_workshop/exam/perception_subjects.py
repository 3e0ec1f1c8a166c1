"""Checks of the lab "perception", part one: the lane in a single picture.

The stages are called with known arguments.
"""

from __future__ import annotations

import math
from typing import Any, Iterator

import numpy as np

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.library_subjects import LibrarySubject, hint_for, shown
from sdc_workshop.exam.probe import same
from sdc_workshop.exam.probes import perception_probe as probe
from sdc_workshop.steps import LABS


class PerceptionSubject(LibrarySubject):
    """A module of the library of the lab."""

    package = LABS["perception"]


class GroundPlaneSubject(PerceptionSubject):
    """ground_plane.py, TODO 1 and 2."""

    module = "ground_plane"
    todos = ("1", "2")

    def _problems(self, found: dict) -> Iterator[Problem]:
        x, z, pitch = probe.MOUNT
        c, s = math.cos(pitch), math.sin(pitch)
        frame = found["frame"]
        for row, (name, wanted, typical, law) in enumerate(_optical_rows(x, z, c, s)):
            got = frame[row] if np.shape(frame) == (3, 3) else frame
            if not same(got, wanted):
                hint = hint_for(got, typical, law)
                yield Problem(f"{name}: {shown(wanted)}", shown(got), hint, "1")
                break
        yield from _projection_problems(found["pixels"])


def _optical_rows(x: float, z: float, c: float, s: float) -> tuple:
    """Return (name, right row, ((typical wrong row, hint), ...), law) of the optical frame."""
    pitch = (
        "The sign of the pitch is wrong: with a positive pitch the camera looks down, so a point "
        "far ahead is nearer to the centre of the picture from above: -s * x."
    )
    height = (
        "The height z_m is missing or not used: the ground is c * z_m below the camera. With a "
        "wrong height the metres of all pixels are wrong by the same factor."
    )
    return (
        (
            "right, from x, y and 1",
            [0.0, -1.0, 0.0],
            (
                (
                    [0.0, 1.0, 0.0],
                    "left and right are swapped: y of the car points to its left, the optical "
                    "frame's x axis to the right: -y.",
                ),
                ([1.0, 0.0, 0.0], "This is x, the distance ahead: to the right is -y."),
            ),
            "Only y counts: to the right is -y.",
        ),
        (
            "down, from x, y and 1",
            [-s, 0.0, s * x + c * z],
            (
                (
                    [s, 0.0, -s * x - c * z],
                    "The picture is upside down: down is positive below the camera, where the "
                    "ground is.",
                ),
                ([s, 0.0, -s * x + c * z], pitch),
                ([-s, 0.0, s * x + c], height),
                ([-s, 0.0, s * x + z], height),
                ([-s, 0.0, s * x], height),
                ([-s, 0.0, s * x - c * z], f"The sign of the height is wrong. {height}"),
                ([-s, 0.0, c * z], "x_m is missing: the camera is ahead of the centre of the car."),
                ([-c, 0.0, c * x + s * z], "c and s are swapped: the camera looks ahead."),
            ),
            "down is -s (x - x_m) + c z_m: the part of x in the first place, that of 1 in the "
            "last. Is a sign wrong?",
        ),
        (
            "ahead, from x, y and 1",
            [c, 0.0, -c * x + s * z],
            (
                ([c, 0.0, s * z], "x_m is missing: the camera is ahead of the centre of the car."),
                (
                    [c, 0.0, c * x + s * z],
                    "The sign of x_m is wrong: the camera is ahead of the centre of the car, so "
                    "the ground is nearer to it.",
                ),
                ([c, 0.0, -c * x], "The height z_m is missing: along the view, the ground is s z."),
                ([c, 0.0, -c * x - s * z], pitch),
                ([-c, 0.0, c * x - s * z], "The sign is wrong: ahead is positive along the view."),
                ([s, 0.0, -s * x + c * z], "c and s are swapped: the camera looks ahead."),
            ),
            "ahead is c (x - x_m) + s z_m: the part of x in the first place, that of 1 in the "
            "last.",
        ),
    )


def _projection_problems(got: Any) -> Iterator[Problem]:
    mapped = probe.GROUND @ probe.HOMOGRAPHY[:, :2].T + probe.HOMOGRAPHY[:, 2]
    depth = mapped[:, 2:]
    divided = mapped[:, :2] / depth
    wanted = np.where(depth > 0.0, divided, probe.NOWHERE)
    undivided = (
        "It is not divided by the depth: without it a metre far away has as many pixels as a metre "
        "next to the car, and the metres of all pixels are wrong."
    )
    typical = (
        (mapped[:, :2], undivided),
        (np.where(depth > 0.0, mapped[:, :2], probe.NOWHERE), undivided),
        (
            divided,
            "A point behind the camera gets a pixel: where the depth is not positive, the result "
            "is np.nan.",
        ),
        (
            np.where(depth < 0.0, divided, probe.NOWHERE),
            "It is inverted: what is ahead of the camera has a positive depth.",
        ),
        (
            np.where(depth > 0.0, mapped[:, :2] * depth, probe.NOWHERE),
            "Divide by the depth: a point twice as far away is half as far from the centre.",
        ),
    )
    if not same(got, wanted.tolist()):
        law = "The first two coordinates divided by the depth, the third one; NaN behind."
        hint = hint_for(got, [(value.tolist(), text) for value, text in typical], law)
        seen = shown(np.ravel(got).tolist()).replace(f"{probe.NOWHERE:.3f}", "NaN")
        text = shown(wanted.ravel().tolist()).replace(f"{probe.NOWHERE:.3f}", "NaN")
        yield Problem(f"the pixels {text}", seen, hint, "2")


class MarkingFilterSubject(PerceptionSubject):
    """marking_filter.py, TODO 3 and 6."""

    module = "marking_filter"
    todos = ("3", "6")

    def _problems(self, found: dict) -> Iterator[Problem]:
        got = found["markings"]
        for index, (wanted, what, hint) in enumerate(_MARKINGS):
            if len(got) != len(_MARKINGS) or got[index] != wanted:
                if got == [not right for right, _, _ in _MARKINGS]:
                    hint = f"It is inverted. {hint}"
                elif not any(got):
                    hint = (
                        "It accepts nothing: width_m between 0.5 and 2.0 times MARKING_M, inside "
                        "more than _BRIGHTER times the brighter side."
                    )
                yield Problem(f"{what}: {wanted}", str(not wanted), hint, "3")
                break
        yield from _ridge_problems(found)


_SIDE = (
    "This is brighter than one of its sides only, as a kerb or the edge of a shadow: a marking is "
    "brighter than both sides. np.maximum takes the brighter one."
)
# Right result, what the edges are, and the hint where the result is another one.
_MARKINGS: tuple = (
    (True, "a bright stripe of 0.15 m", "A marking is brighter inside than next to it."),
    (
        True,
        "a bright stripe of 0.25 m",
        "Up to twice 0.15 m: lines have several widths.",
    ),
    (
        False,
        "a dark stripe between bright sides",
        "The brightness is not used, or inverted: a marking is brighter than what is next to it.",
    ),
    (False, "a step from dark to bright, on its right", _SIDE),
    (False, "a step from bright to dark, on its left", _SIDE),
    (
        False,
        "a bright stripe of 0.05 m",
        "The width is not used, or has no lower limit: 0.5 * MARKING_M.",
    ),
    (False, "a bright stripe of 0.5 m", "The width has no upper limit: 2.0 * MARKING_M."),
    (
        False,
        "a stripe that is 18 % brighter",
        "inside must be more than _BRIGHTER times as bright: asphalt has bright spots, too.",
    ),
)


def _ridge_problems(found: dict) -> Iterator[Problem]:
    left, centre, right = probe.LEFT, probe.CENTRE, probe.RIGHT
    side = np.maximum(left, right)
    typical = [
        (centre - np.minimum(left, right), _SIDE),
        (
            centre - 0.5 * (left + right),
            "This takes the mean of the sides: next to a shadow it is bright on one side only. "
            "np.maximum takes the brighter one.",
        ),
        (side - centre, "The sign is wrong: the centre is brighter."),
        (centre - left, "The right side is missing."),
        (centre - right, "The left side is missing."),
    ]
    got, wanted = found["ridge"], (centre - side).tolist()
    law = "centre minus the brighter one of the sides, np.maximum(left, right)."
    if not same(got, wanted):
        hint = hint_for(got, [(value.tolist(), text) for value, text in typical], law)
        yield Problem(f"the differences {shown(wanted)}", shown(got), hint, "6")
        return
    dark_left, dark_centre, dark_right = probe.DARK
    wanted = [dark_centre - max(dark_left, dark_right)]
    if not same(found["dark"], wanted):
        hint = f"A dark stripe is no marking: the difference must be negative there, {law}"
        yield Problem(f"a dark stripe: {shown(wanted)}", shown(found["dark"]), hint, "6")


class LaneModelSubject(PerceptionSubject):
    """lane_model.py, TODO 4 and 5."""

    module = "lane_model"
    todos = ("4", "5")

    def _problems(self, found: dict) -> Iterator[Problem]:
        yield from _distance_problems(found["distances"])
        yield from _best_lane_problems(found["best"])


def _distance_problems(got: Any) -> Iterator[Problem]:
    x, y = probe.POINT[0]
    for index, (name, centre, typical) in enumerate(_CENTRES):
        wanted = (y - centre - probe.LINES_M).tolist()
        one = np.array(got)[index, 0].tolist() if np.shape(got) == (3, 1, 3) else got
        if same(one, wanted):
            continue
        cases = [
            (
                (y - centre + probe.LINES_M).tolist(),
                "The lines are swapped: lines_m is positive to the left of the centre, so a point "
                "on the left line has y = centre + lines_m, and the distance is y - centre - "
                "lines_m.",
            ),
            (
                (-(y - centre) + probe.LINES_M).tolist(),
                "The sign is wrong: the distance is that of the point, to the left of the line.",
            ),
            *(((y - other - probe.LINES_M).tolist(), text) for other, text in typical),
        ]
        law = (
            "y minus the centre minus lines_m; the centre is -offset + heading x + curvature x^2/2."
        )
        hint = hint_for(one, cases, law)
        seen = f"distances {shown(np.ravel(one).tolist())}"
        yield Problem(
            f"{name}, a point at (10.00, 0.25): distances {shown(wanted)}", seen, hint, "4"
        )
        return


# Name, right centre at x = 10, ((typical wrong centre, hint), ...) of each lane of the probe.
_CENTRES: tuple = (
    (
        "a car 0.5 m to the left of the centre",
        -0.5,
        (
            (
                0.5,
                "The sign of the offset is wrong: a car that is to the left of the centre has it "
                "on its right, at negative y.",
            ),
            (0.0, "The offset is missing."),
        ),
    ),
    (
        "a lane that points 0.1 rad to the left",
        1.0,
        (
            (-1.0, "The sign of the heading is wrong: a lane that points to the left grows in y."),
            (0.1, "The heading must be multiplied by x: an angle moves what is far away more."),
            (0.0, "The heading is missing."),
        ),
    ),
    (
        "a bend to the left of 0.03 1/m",
        1.5,
        (
            (3.0, "The half is missing: a circle of curvature k is at k x^2 / 2."),
            (0.15, "It must be x squared: a bend moves the lane by curvature times x * x / 2."),
            (0.3, "It must be x squared, and half of it."),
            (-1.5, "The sign of the curvature is wrong: it is positive to the left."),
            (0.0, "The curvature is missing."),
        ),
    ),
)


def _best_lane_problems(got: Any) -> Iterator[Problem]:
    lanes = probe.CANDIDATES
    wanted = lanes[2].tolist()
    if same(got, wanted):
        return
    typical = (
        (
            lanes[1].tolist(),
            "This fit is not robust: its squared distances are small because it goes halfway to "
            "the wrong points. Count the points that are near, and ignore how far the others are.",
        ),
        (lanes[3].tolist(), "This is the lane with the fewest points: use np.argmax."),
        (
            lanes.mean(axis=0).tolist(),
            "This is the mean of all lanes: most of them are wrong. Choose one.",
        ),
        (lanes[0].tolist(), "This is the first lane. Count the points on each one."),
    )
    law = (
        "lanes[index] of the lane with the most points: np.argmax of the counts. Return the lane, "
        "not how many points it has."
    )
    seen = shown(got if isinstance(got, list) else [got])
    yield Problem(f"the lane {shown(wanted)}", seen, hint_for(got, typical, law), "5")


PICTURE_SUBJECTS = (
    GroundPlaneSubject(),
    MarkingFilterSubject(),
    LaneModelSubject(),
)
