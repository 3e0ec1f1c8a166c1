"""The places in the car's library that a student writes: called with numbers whose answers are known."""

from __future__ import annotations

import math

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.probe import probe
from sdc_workshop.exam.subject import Subject
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

_NEAR = 1e-6
# What library_probe.py asks for.
YAWS = (0.0, 0.5, 1.5, 2.8, -0.5, -1.5, -2.8)


class LibrarySubject(Subject):
    """A module of the library; `_problems` looks at what library_probe.py has found."""

    module: str

    @property
    def file(self) -> str:
        return f"{PACKAGE}/src/{PACKAGE}/{self.module}.py"

    def problems(self, variant: Variant, stage) -> list:
        found = probe(variant, stage, self.module)
        return [found] if isinstance(found, Problem) else list(self._problems(found))

    def _problems(self, found):
        raise NotImplementedError


def same(got, wanted) -> bool:
    """Whether two numbers, or two lists of them, are equal but for rounding."""
    if isinstance(wanted, list):
        return len(got) == len(wanted) and all(map(same, got, wanted))
    return isinstance(got, (int, float)) and abs(got - wanted) < _NEAR


def shown(numbers) -> str:
    row = numbers if isinstance(numbers, list) else [numbers]
    words = (
        "nothing"
        if number is None
        else f"{number:.3f}"
        if isinstance(number, (int, float))
        else str(number)
        for number in row
    )
    return ", ".join(words)


class PidSubject(LibrarySubject):
    module = "pid"
    todos = ("2.6",)

    def _problems(self, found):
        for name, wanted, what, hints in (
            (
                "proportional",
                [6.0],
                "kp = 2 and an error of 3 m/s: output",
                (
                    (
                        [-6.0],
                        "The sign: the error is the setpoint less the measurement; a car that is too slow has to speed up.",
                    ),
                    ([0.0], "The proportional part is missing: kp times the error."),
                ),
            ),
            (
                "feed_forward",
                [0.7],
                "no error and a feed_forward of 0.7: output",
                (
                    (
                        [0.0],
                        "feed_forward is missing in the sum: it is what the road asks for anyway.",
                    ),
                    ([-0.7], "feed_forward has the wrong sign."),
                ),
            ),
            (
                "integral",
                [0.1, 0.2, 0.3],
                "ki = 0.5 and an error of 2 m/s, three steps of 0.1 s: outputs",
                (
                    (
                        [1.0, 2.0, 3.0],
                        "The time step dt_s is missing: the integral grows by ki times error times dt_s, whatever the rate of the "
                        "messages.",
                    ),
                    (
                        [0.1, 0.1, 0.1],
                        "The integral does not grow: the new one is the old one, self.integral, and a bit more.",
                    ),
                    (
                        [0.0, 0.0, 0.0],
                        "The integral part is missing in the sum, or never grows: self.integral and ki times error times dt_s.",
                    ),
                    ([-0.1, -0.2, -0.3], "The sign of the integral part is wrong."),
                    ([0.2, 0.4, 0.6], "The gain ki is missing in the integral."),
                ),
            ),
            (
                "derivative",
                [0.0, -5.0],
                "kd = 1 and a speed that grows by 0.5 m/s in 0.1 s: outputs",
                (
                    (
                        [0.0, 5.0],
                        "The sign of the derivative part is wrong: a speed that grows must be damped. `derivative` is already the rate "
                        "of the error: it is added.",
                    ),
                    ([0.0, 0.0], "The derivative part is missing: kd times derivative."),
                ),
            ),
            ("all", [6.45, 5.99], "all three parts: outputs", ()),
        ):
            got = found[name]
            if not same(got, wanted):
                hint = next(
                    (text for value, text in hints if same(got, value)),
                    "The output is feed_forward + kp * error + integral + kd * derivative, and the new integral is the old one + ki * "
                    "error * dt_s.",
                )
                yield Problem(f"{what} {shown(wanted)}", shown(got), hint, "2.6")


class StanleySubject(LibrarySubject):
    module = "stanley"
    todos = ("2.7",)

    def _problems(self, found):
        left = -math.atan2(1.25, 5.0)
        for name, wanted, what, hints in (
            (
                "heading",
                0.2,
                "on the path, which leads 0.2 rad to the left of where the car points: an angle of",
                (
                    (
                        0.2 - math.pi / 2,
                        "The two arguments of math.atan2 are swapped: the first is k times the error, the second the speed.",
                    ),
                    (
                        -0.2,
                        "The sign of the heading error is wrong: the wheels turn to where the path leads.",
                    ),
                    (0.0, "The heading error is missing: the wheels first point along the path."),
                ),
            ),
            (
                "left",
                left,
                "0.5 m to the left of the path at 5 m/s, k = 2.5: an angle of",
                (
                    (
                        -left,
                        "The sign of the cross-track part is wrong: a car to the left of its path (positive error) has to steer to the "
                        "right (negative angle).",
                    ),
                    (
                        0.0,
                        "The cross-track part is missing: without it the car never comes back to its path.",
                    ),
                    (
                        -math.atan2(5.0, 1.25),
                        "The two arguments of math.atan2 are swapped: the first is k times the error, the second the speed.",
                    ),
                    (-math.atan2(0.5, 5.0), "k is missing: it is multiplied with the error."),
                ),
            ),
            ("right", -left, "0.5 m to the right: an angle of", ()),
            (
                "slow",
                -math.atan2(1.25, 1.0),
                "the same at 1 m/s: an angle of",
                ((left, "The speed is missing: a slow car has to steer more."),),
            ),
            ("stronger", -math.atan2(2.5, 5.0), "with k = 5: an angle of", ()),
            (
                "softened",
                -math.atan2(1.25, 7.0),
                "with a softening of 2 m/s: an angle of",
                ((left, "softening_mps is missing: it is added to the speed."),),
            ),
            ("both", 0.1 - math.atan2(1.25, 6.0), "with both errors: an angle of", ()),
            ("standing", 0.0, "standing on the path: an angle of", ()),
        ):
            got = found[name]
            if not same(got, wanted):
                hint = next(
                    (text for value, text in hints if same(got, value)),
                    "The angle is the heading error less atan2 of (k times cross-track error) and (softening plus speed).",
                )
                yield Problem(f"{what} {wanted:.3f} rad", shown(got), hint, "2.7")


class OdometrySubject(LibrarySubject):
    module = "odometry"
    todos = ("2.4", "2.5")

    def _problems(self, found):
        wanted, got = list(YAWS), found["yaws"]
        if not same(got, wanted):
            halves = [yaw / 2 for yaw in wanted]
            hint = "yaw is atan2(2 (w z + x y), 1 - 2 (y y + z z))."
            for value, text in (
                (
                    [math.degrees(yaw) for yaw in wanted],
                    "These are degrees; angles are in radians everywhere.",
                ),
                (
                    [-yaw for yaw in wanted],
                    "The sign is wrong: yaw grows counter-clockwise, to the left.",
                ),
                (
                    [math.sin(yaw / 2) for yaw in wanted],
                    "This is z of the quaternion, the sine of half the angle, and not yet the angle: yaw is an atan2.",
                ),
                (
                    halves,
                    "This is half the angle: a quaternion holds half angles, hence the factors 2.",
                ),
                (
                    [math.atan2(math.cos(yaw), math.sin(yaw)) for yaw in wanted],
                    "The two arguments of math.atan2 are swapped: it is atan2(sine part, cosine part).",
                ),
                (
                    [math.atan2(math.sin(yaw) / 2, math.cos(yaw)) for yaw in wanted],
                    "A factor 2 is missing before (w z + x y).",
                ),
                (
                    [math.asin(math.sin(yaw)) for yaw in wanted],
                    "asin only knows -90 to 90 degrees; atan2 knows all directions.",
                ),
            ):
                if same(got, value):
                    hint = text
            yield Problem(
                f"the yaws {shown(wanted)} rad from their quaternions", shown(got), hint, "2.4"
            )
        elif not same(found["tilted"], 0.6):
            yield Problem(
                "yaw 0.600 rad of a car that also pitches and rolls",
                shown(found["tilted"]),
                "On a slope x and y of the quaternion are not zero: the terms x y and y y belong to the formula.",
                "2.4",
            )
        wanted, got = [5.0, 3.0, 2.0, 0.0], found["speeds"]
        if not same(got, wanted):
            hint = "The speed is the length of the vector: math.hypot(velocity.x, velocity.y)."
            for value, text in (
                (
                    [7.0, -3.0, -2.0, 0.0],
                    "x and y are not simply added: the length of the vector is the root of the sum of their squares, math.hypot.",
                ),
                (
                    [3.0, -3.0, 0.0, 0.0],
                    "y is missing: some worlds give the velocity in the map's frame, where a car that drives north has all its speed in y.",
                ),
                (
                    [25.0, 9.0, 4.0, 0.0],
                    "The root is missing: this is the square of the speed. math.hypot does it all.",
                ),
                (
                    [3.0, 3.0, 0.0, 0.0],
                    "y is missing: some worlds give the velocity in the map's frame, where a car that drives north has all its speed in y.",
                ),
            ):
                if same(got, value):
                    hint = text
            yield Problem(
                f"the speeds {shown(wanted)} m/s for the velocities (3, 4), (-3, 0), (0, -2), (0, 0)",
                shown(got),
                hint,
                "2.5",
            )


class WaypointSearchSubject(LibrarySubject):
    module = "waypoint_search"
    todos = ("5", "6")

    def _problems(self, found):
        wanted, got = [0, 3, 5, 6, 4, 0], found["nearest"]
        if not same(got, wanted):
            hint = "self.tree.query((x_m, y_m)) answers with the pair (distance, index): the index is wanted."
            if got == [None] * 6:
                pass
            elif got == [0] * 6:
                hint = (
                    "It is always 0: "
                    + hint
                    + " Is the distance, made a whole number, taken for it?"
                )
            elif any(isinstance(value, float) for value in got):
                hint = "These are distances: " + hint
            else:
                hint = "Are x and y swapped? " + hint
            yield Problem(
                "the indices 0, 3, 5, 6, 4, 0 of the nearest waypoints",
                ", ".join(str(value) for value in got),
                hint,
                "5",
            )
        wanted, got = [False, True, False, True], found["behind"]
        if got != wanted:
            hint = (
                "The way from the car to the waypoint (waypoint less car), times the direction of the route: the dot product is "
                "negative when the waypoint lies behind."
            )
            if got == [not value for value in wanted]:
                hint = (
                    "It is turned round: behind is where the dot product is negative (< 0), and the vector leads from the car to the "
                    "waypoint: waypoint less car."
                )
            elif not any(got):
                hint = "It never says True: the dot product of the two vectors has to be compared with 0."
            yield Problem(
                "waypoints ahead: no, yes behind: False, True, False, True",
                ", ".join(map(str, got)),
                hint,
                "6",
            )
