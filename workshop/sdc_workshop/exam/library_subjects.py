"""Checks of the car's library: functions are called with arguments whose results are known."""

from __future__ import annotations

import math
from typing import Callable, Iterable, Iterator

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.probe import probe, same
from sdc_workshop.exam.stage import Stage
from sdc_workshop.exam.subject import Subject
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

# The arguments of library_probe.py.
YAWS = (0.0, 0.5, 1.5, 2.8, -0.5, -1.5, -2.8)


class LibrarySubject(Subject):
    """A module of the library.

    Attributes:
        module: path of the module in the library, without its ending
        package: package of the library
    """

    module: str
    package = PACKAGE

    @property
    def file(self) -> str:  # type: ignore[override]
        """Path of the module relative to the src folder."""
        return f"{self.package}/src/{self.package}/{self.module}.py"

    def problems(self, variant: Variant, stage: Stage) -> list:
        """See Subject.problems."""
        found = probe(variant, stage, self.module.rpartition("/")[2])
        if isinstance(found, Problem):
            return [found]
        problems = list(self._problems(found))
        if problems or found["as_solved"]:
            return problems
        seen = "it gives the results of the usual arguments only"
        stage.report(f"{variant.name}: {seen}, as if they were written into it")
        hint = "Each check also calls it with other arguments. Compute the results from them."
        todo = variant.judged[-1] if variant.judged else None
        return [Problem("the right results for all arguments", seen, hint, todo)]

    def _problems(self, found: dict) -> Iterator[Problem]:
        """Yield what is wrong with the results of library_probe.py."""
        raise NotImplementedError


def shown(numbers: object) -> str:
    """Return numbers as text."""
    row = numbers if isinstance(numbers, list) else [numbers]
    return ", ".join(
        f"{number:.3f}" if isinstance(number, (int, float)) else str(number) for number in row
    )


def hint_for(got: object, typical: Iterable[tuple], otherwise: str) -> str:
    """Return the hint of the typical wrong result that this result is, or another hint."""
    return next((text for value, text in typical if same(got, value)), otherwise)


# Results of Pid: (key, right result, description, ((typical wrong result, hint), ...)).
_PID = (
    (
        "proportional",
        [6.0],
        "kp = 2 and an error of 3 m/s: output",
        (
            (
                [-6.0],
                "The sign: the error is the setpoint minus the measurement; a car that is too slow "
                "must accelerate.",
            ),
            ([0.0], "The proportional part is missing: kp times the error."),
        ),
    ),
    (
        "feed_forward",
        [0.7],
        "no error and a feed_forward of 0.7: output",
        (
            ([0.0], "feed_forward is missing in the sum: it is the planned acceleration."),
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
                "The time step dt_s is missing: in each step the integral grows by ki times error "
                "times dt_s.",
            ),
            (
                [0.1, 0.1, 0.1],
                "The integral does not grow: the new one is the old one, self.integral, plus "
                "ki * error * dt_s.",
            ),
            (
                [0.0, 0.0, 0.0],
                "The integral part is missing in the sum, or never grows: self.integral plus ki "
                "times error times dt_s.",
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
                "The sign of the derivative part is wrong: `derivative` is the rate of the error, "
                "which is added.",
            ),
            ([0.0, 0.0], "The derivative part is missing: kd times derivative."),
        ),
    ),
    ("all", [6.45, 5.99], "all three parts: outputs", ()),
)
_PID_LAW = (
    "The output is feed_forward + kp * error + integral + kd * derivative, and the new integral is "
    "the old one + ki * error * dt_s."
)


class PidSubject(LibrarySubject):
    """pid.py, TODO 2.6."""

    module = "pid"
    todos = ("2.6",)

    def _problems(self, found: dict) -> Iterator[Problem]:
        for name, wanted, what, typical in _PID:
            got = found[name]
            if not same(got, wanted):
                hint = hint_for(got, typical, _PID_LAW)
                yield Problem(f"{what} {shown(wanted)}", shown(got), hint, "2.6")


_LEFT = -math.atan2(1.25, 5.0)
_SWAPPED = (
    "The two arguments of math.atan2 are swapped: the first is k times the error, the second the "
    "speed."
)
_STANDSTILL = (
    "At standstill this divides by zero: the speed, and with it the denominator, is 0. Use "
    "math.atan2(k * e, softening + v), which is defined there, too."
)
# Results of stanley_angle, as above.
_STANLEY = (
    (
        "heading",
        0.2,
        "on a path that leads 0.2 rad to the left of the car's heading: an angle of",
        (
            (0.2 - math.pi / 2, _SWAPPED),
            (
                -0.2,
                "The sign of the heading error is wrong: the wheels turn towards the direction of "
                "the path.",
            ),
            (0.0, "The heading error is missing: the wheels first turn parallel to the path."),
        ),
    ),
    (
        "left",
        _LEFT,
        "0.5 m left of the path at 5 m/s, k = 2.5: an angle of",
        (
            (
                -_LEFT,
                "The sign of the cross-track part is wrong: a car left of its path (positive "
                "error) must steer right (negative angle).",
            ),
            (
                0.0,
                "The cross-track part is missing: without it the car does not return to its path.",
            ),
            (-math.atan2(5.0, 1.25), _SWAPPED),
            (-math.atan2(0.5, 5.0), "k is missing: multiply it with the error."),
        ),
    ),
    ("right", -_LEFT, "0.5 m right of the path: an angle of", ()),
    (
        "slow",
        -math.atan2(1.25, 1.0),
        "the same at 1 m/s: an angle of",
        ((_LEFT, "The speed is missing: a slow car must steer more."),),
    ),
    ("stronger", -math.atan2(2.5, 5.0), "with k = 5: an angle of", ()),
    (
        "softened",
        -math.atan2(1.25, 7.0),
        "with a softening of 2 m/s: an angle of",
        ((_LEFT, "softening_mps is missing: add it to the speed."),),
    ),
    ("both", 0.1 - math.atan2(1.25, 6.0), "with both errors: an angle of", ()),
    ("standstill_on_path", 0.0, "at standstill on the path, softening 0: an angle of", ()),
    (
        "standstill",
        -math.pi / 2,
        "at standstill left of the path, softening 0: an angle of",
        (),
    ),
)


class StanleySubject(LibrarySubject):
    """steering/stanley.py, TODO 2.7."""

    module = "steering/stanley"
    todos = ("2.7",)

    def _problems(self, found: dict) -> Iterator[Problem]:
        for name, wanted, what, typical in _STANLEY:
            got = found[name]
            if same(got, wanted):
                continue
            hint = hint_for(
                got,
                typical,
                "The angle is the heading error minus atan2 of (k times cross-track error) and "
                "(softening plus speed).",
            )
            if got == "ZeroDivisionError" or got != got:  # NaN differs from itself
                hint = _STANDSTILL
            yield Problem(f"{what} {wanted:.3f} rad", shown(got), hint, "2.7")


_MAP_FRAME = (
    "y is missing: some simulators give the velocity in the map frame, where a car that drives "
    "north has its whole speed in y."
)
_YAW_LAW = "yaw is atan2(2 (w z + x y), 1 - 2 (y y + z z))."


def _of_yaws(function: Callable[[float], float]) -> list:
    return [function(yaw) for yaw in YAWS]


_YAW_MISTAKES = (
    (_of_yaws(math.degrees), "These are degrees; all angles are in radians."),
    (
        _of_yaws(lambda yaw: -yaw),
        "The sign is wrong: yaw is positive counter-clockwise, to the left.",
    ),
    (
        _of_yaws(lambda yaw: math.sin(yaw / 2)),
        "This is z of the quaternion, the sine of half the angle: yaw is an atan2.",
    ),
    (
        _of_yaws(lambda yaw: yaw / 2),
        "This is half the angle: a quaternion holds half angles, hence the factors 2.",
    ),
    (
        _of_yaws(lambda yaw: math.atan2(math.cos(yaw), math.sin(yaw))),
        "The two arguments of math.atan2 are swapped: it is atan2(sine part, cosine part).",
    ),
    (
        _of_yaws(lambda yaw: math.atan2(math.sin(yaw) / 2, math.cos(yaw))),
        "A factor 2 is missing before (w z + x y).",
    ),
    (
        _of_yaws(lambda yaw: math.asin(math.sin(yaw))),
        "asin returns only -90 to 90 degrees; atan2 returns all directions.",
    ),
)
_SPEED_MISTAKES = (
    (
        [7.0, -3.0, -2.0, 0.0],
        "x and y are not added: the length of the vector is the root of the sum of their squares, "
        "math.hypot.",
    ),
    ([3.0, -3.0, 0.0, 0.0], _MAP_FRAME),
    ([3.0, 3.0, 0.0, 0.0], _MAP_FRAME),
    (
        [25.0, 9.0, 4.0, 0.0],
        "The root is missing: this is the speed squared. Use math.hypot.",
    ),
)


class OdometrySubject(LibrarySubject):
    """odometry.py, TODO 2.4 and 2.5."""

    module = "odometry"
    todos = ("2.4", "2.5")

    def _problems(self, found: dict) -> Iterator[Problem]:
        wanted, got = list(YAWS), found["yaws"]
        if not same(got, wanted):
            yield Problem(
                f"the yaws {shown(wanted)} rad from their quaternions",
                shown(got),
                hint_for(got, _YAW_MISTAKES, _YAW_LAW),
                "2.4",
            )
        elif not same(found["tilted"], 0.6):
            yield Problem(
                "yaw 0.600 rad of a car that also pitches and rolls",
                shown(found["tilted"]),
                "On a slope x and y of the quaternion are not zero: the formula needs x y and y y.",
                "2.4",
            )
        wanted, got = [5.0, 3.0, 2.0, 0.0], found["speeds"]
        if not same(got, wanted):
            law = "The speed is the length of the vector: math.hypot(velocity.x, velocity.y)."
            yield Problem(
                f"the speeds {shown(wanted)} m/s for the velocities (3, 4), (-3, 0), (0, -2), "
                "(0, 0)",
                shown(got),
                hint_for(got, _SPEED_MISTAKES, law),
                "2.5",
            )


class WaypointSearchSubject(LibrarySubject):
    """waypoint_search.py, TODO 5 and 6."""

    module = "waypoint_search"
    todos = ("5", "6")

    def _problems(self, found: dict) -> Iterator[Problem]:
        wanted, got = [0, 3, 5, 6, 4, 0], found["nearest"]
        if not same(got, wanted):
            hint = "self.tree.query((x_m, y_m)) returns (distance, index): return the index."
            if got == [0] * 6:
                hint = f"It is always 0: {hint} Is the distance, rounded, returned instead?"
            elif any(isinstance(value, float) for value in got):
                hint = f"These are distances: {hint}"
            elif got != [None] * 6:
                hint = f"Are x and y swapped? {hint}"
            expected = "the indices 0, 3, 5, 6, 4, 0 of the nearest waypoints"
            yield Problem(expected, ", ".join(map(str, got)), hint, "5")
        expected_behind, behind = [False, True, False, True], found["behind"]
        if behind != expected_behind:
            hint = (
                "The dot product of the vector from the car to the waypoint (waypoint minus car) "
                "and the direction of the route is negative when the waypoint is behind."
            )
            if behind == [not value for value in expected_behind]:
                hint = (
                    "The result is inverted: the waypoint is behind where the dot product is "
                    "negative (< 0), and the vector is waypoint minus car."
                )
            elif not any(behind):
                hint = "It never returns True: compare the dot product of the two vectors with 0."
            yield Problem(
                "behind the car: False, True, False, True", ", ".join(map(str, behind)), hint, "6"
            )
