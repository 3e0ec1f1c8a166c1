"""Checks of the lab "localization": the equations are called with known arguments."""

from __future__ import annotations

import math
from typing import Any, Iterator

import numpy as np

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.library_subjects import LibrarySubject, hint_for, shown
from sdc_workshop.exam.probe import same
from sdc_workshop.exam.probes import localization_probe as probe
from sdc_workshop.steps import LABS

_WRAPPED = (
    "The heading is not wrapped: -pi and pi are the same direction, and a difference of two "
    "headings is right only if both are in -pi..pi. Use wrap_angle(...)."
)
_STEP = "The time step is missing: a distance is speed times step_s, an angle is rate times step_s."


class LocalizationSubject(LibrarySubject):
    """A module of the library of the lab."""

    package = LABS["localization"]


class MotionModelSubject(LocalizationSubject):
    """motion_model.py, TODO 1 and 2."""

    module = "motion_model"
    todos = ("1", "2")

    def _problems(self, found: dict) -> Iterator[Problem]:
        for name, wanted, what, typical in _MOTIONS:
            got = found[name]
            if not same(got, wanted):
                law = (
                    "x grows by (speed cos - sideways sin) step_s, y by (speed sin + sideways cos) "
                    "step_s, the heading by turn; bias and scale error stay."
                )
                expected = f"{what}: x, y, yaw, bias, scale error {shown(wanted)}"
                yield Problem(expected, shown(got), hint_for(got, typical, law), "1")
                break
        yield from _jacobian_problems(found["jacobian"])


# Result of the probe, right value, description, ((typical wrong value, hint), ...).
_MOTIONS: tuple = (
    (
        "straight",
        [1.0, 0.0, 0.0, 0.0, 0.0],
        "0.1 s at 10 m/s to the east",
        (
            ([10.0, 0.0, 0.0, 0.0, 0.0], _STEP),
            (
                [0.0, 1.0, 0.0, 0.0, 0.0],
                "cos and sin are swapped: a heading of 0 points along x, whose part is cos.",
            ),
            ([-1.0, 0.0, 0.0, 0.0, 0.0], "The sign is wrong: the car drives forward."),
        ),
    ),
    (
        "north",
        [0.0, 1.0, 0.5 * math.pi, 0.0, 0.0],
        "0.1 s at 10 m/s to the north",
        (
            ([0.0, 0.0, 0.5 * math.pi, 0.0, 0.0], "y is missing: it grows by speed * sin."),
            (
                [0.0, -1.0, 0.5 * math.pi, 0.0, 0.0],
                "The sign of y is wrong: in ROS y points to the left of x, to the north.",
            ),
            ([1.0, 0.0, 0.5 * math.pi, 0.0, 0.0], "The heading is not used: x grows by cos."),
        ),
    ),
    (
        "sideways",
        [0.0, 0.1, 0.0, 0.0, 0.0],
        "0.1 s at 1 m/s to the left",
        (
            ([0.0, 0.0, 0.0, 0.0, 0.0], "sideways_mps is missing: in a bend the centre slides."),
            (
                [0.0, -0.1, 0.0, 0.0, 0.0],
                "The sign of sideways_mps is wrong: it is positive to the left, along (-sin, cos).",
            ),
        ),
    ),
    (
        "turn",
        [0.0, 0.0, 0.03, 0.2, 0.0],
        "0.1 s with a gyroscope that measures 0.5 rad/s, 0.2 of them bias",
        (
            (
                [0.0, 0.0, 0.05, 0.2, 0.0],
                "The bias is not subtracted: turn has it subtracted already; use turn.",
            ),
            (
                [0.0, 0.0, 0.3, 0.2, 0.0],
                f"{_STEP} turn is an angle already.",
            ),
            (
                [0.0, 0.0, 0.003, 0.2, 0.0],
                "The time step is there twice: turn is an angle already.",
            ),
            ([0.0, 0.0, 0.0, 0.2, 0.0], "The heading does not change: add turn."),
            ([0.0, 0.0, -0.03, 0.2, 0.0], "The sign is wrong: a positive turn is to the left."),
            ([0.0, 0.0, math.degrees(0.03), 0.2, 0.0], "These are degrees; angles are in radians."),
        ),
    ),
    (
        "wrap",
        [0.0, 0.0, 3.2 - 2.0 * math.pi, 0.0, 0.0],
        "a turn of 0.1 rad from a heading of 3.1",
        (([0.0, 0.0, 3.2, 0.0, 0.0], _WRAPPED),),
    ),
    (
        "scale",
        [1.1, 0.0, 0.0, 0.0, 0.1],
        "0.1 s at 10 m/s with a scale error of 0.1",
        (
            (
                [1.0, 0.0, 0.0, 0.0, 0.1],
                "The scale error is not used: speed has it already, wheel_mps has not.",
            ),
        ),
    ),
)


def _jacobian_problems(got: Any) -> Iterator[Problem]:
    """Compare the derivatives by heading, by bias and by scale error, in this order."""
    from sdc_localization.motion_model import motion_jacobian

    wanted = motion_jacobian(np.array(probe.STATE), 8.0, 0.5, 0.4, 0.1)
    if np.shape(got) != (5, 5):
        hint = "jacobian already has its size: assign to single elements, jacobian[X, YAW] = ..."
        yield Problem("a Jacobian of 5 rows and 5 columns", str(np.shape(got)), hint, "2")
        return
    found = np.array(got, float)
    for column, rows, name, hints in _COLUMNS:
        one, right = found[rows, column], wanted[rows, column]
        if not same(one.tolist(), right.tolist()):
            cases = {
                "sign": -right,
                "step": right / 0.1,
                "swapped": right[[1, 0, *range(2, len(right))]],
                "missing": np.zeros(len(right)),
            }
            typical = [(value.tolist(), hints[case]) for case, value in cases.items()]
            yield Problem(
                f"derivatives of {'x, y' if len(right) == 2 else 'x, y, yaw'} by {name}: "
                f"{shown(right.tolist())}",
                shown(one.tolist()),
                hint_for(one.tolist(), typical, hints["law"]),
                "2",
            )
            return
    if not same(found.tolist(), wanted.tolist()):
        hint = "All other elements stay as in np.eye(SIZE): each state depends on itself."
        yield Problem("1 on the diagonal and 0 elsewhere", "other numbers", hint, "2")


_COLUMNS: tuple = (
    (
        2,
        [0, 1],
        "the heading",
        {
            "sign": "The sign of the derivatives by the heading is wrong: d cos is -sin. When the "
            "car points more to the left, dx changes by -dy and dy by +dx.",
            "step": "The time step is missing: dx and dy are distances and have it already.",
            "swapped": "x and y are swapped: dx changes by -dy, dy by +dx.",
            "missing": "The derivatives by the heading are missing: without them GNSS never "
            "corrects the heading.",
            "law": "jacobian[X, YAW] is -dy, jacobian[Y, YAW] is dx. Is one sign wrong? d cos is "
            "-sin, d sin is cos.",
        },
    ),
    (
        3,
        [0, 1, 2],
        "the bias",
        {
            "sign": "The sign of the derivatives by the bias is wrong: it is subtracted, so the "
            "car turns less with a greater bias.",
            "step": "The time step is missing: the heading changes by -step_s times the bias.",
            "swapped": "x and y are swapped.",
            "missing": "The derivatives by the bias are missing: the filter never learns it.",
            "law": "The heading changes by -step_s for each unit of bias, and the mean heading of "
            "the step by half of it: is the sign wrong, or the time step missing?",
        },
    ),
    (
        4,
        [0, 1],
        "the scale error",
        {
            "sign": "The sign of the derivatives by the scale error is wrong.",
            "step": "The time step is missing: x changes by wheel_mps * cos * step_s.",
            "swapped": "cos and sin are swapped.",
            "missing": "The derivatives by the scale error are missing.",
            "law": "The speed is (1 + scale) wheel_mps: x changes by wheel_mps * cos * step_s.",
        },
    ),
)


class KalmanFilterSubject(LocalizationSubject):
    """kalman_filter.py, TODO 3 to 8."""

    module = "kalman_filter"
    todos = ("3", "4", "5", "6", "7", "8")

    def _problems(self, found: dict) -> Iterator[Problem]:
        for name, todo, wanted, what, typical, law in _equations():
            got = found[name]
            if same(got, wanted.tolist()):
                continue
            hint = next((text for value, text in typical if same(got, value.tolist())), law)
            matrix = np.array(got, float) if np.shape(got) == wanted.shape else None
            square = matrix is not None and matrix.ndim == 2 and len(matrix) == len(matrix.T)
            if square and hint is law and not np.allclose(matrix, matrix.T):  # type: ignore[union-attr]
                hint = f"The covariance is not symmetric: is a transpose (.T) missing? {law}"
            seen = f"{what} with the diagonal {shown(np.diag(matrix).tolist())}" if square else ""
            yield Problem(
                f"{what} of known matrices"
                + (
                    f" with the diagonal {shown(np.diag(wanted).tolist())}"
                    if square
                    else f": {shown(wanted.ravel().tolist())}"
                ),
                seen or (shown(np.ravel(got).tolist()) if matrix is not None else str(got)[:100]),
                hint,
                todo,
            )
        wanted_gates = [right for *_, right in probe.GATES]
        if found["plausible"] != wanted_gates:
            yield _gate_problem(found["plausible"], wanted_gates)


def _gate_problem(got: list, wanted: list) -> Problem:
    law = (
        "The squared Mahalanobis distance, innovation times inverse of S times innovation, is at "
        "most the limit."
    )
    if all(got):
        law = f"It accepts everything: an update without gating follows each outlier. {law}"
    elif got == [not value for value in wanted]:
        law = f"It is inverted: a plausible measurement is closer than the limit. {law}"
    elif got == [math.hypot(*one) ** 2 <= limit for one, limit, _ in probe.GATES]:
        law = f"S is not used: a distance of 2 m is much for a sure filter only. {law}"
    elif got == [_distance(one) <= limit for one, limit, _ in probe.GATES]:
        law = f"This is the distance, not squared: the limit is one of squares. {law}"
    return Problem(f"plausible: {', '.join(map(str, wanted))}", ", ".join(map(str, got)), law, "6")


def _distance(innovation: tuple) -> float:
    one = np.array(innovation)
    return math.sqrt(one @ np.linalg.inv(probe.S) @ one)


def _equations() -> Iterator[tuple]:
    """Yield (result of the probe, TODO, right value, name, typical wrong values, law)."""
    P, F, Q, H, R, S, K = (getattr(probe, name) for name in "PFQHRSK")
    yield (
        "predicted",
        "3",
        F @ P @ F.T + Q,
        "the covariance",
        (
            (F @ P @ F.T, "Q is missing: a motion makes the filter less sure."),
            (F @ P @ F + Q, "The second F must be transposed, F.T: else it is not symmetric."),
            (F.T @ P @ F + Q, "The transpose is at the wrong F: F @ P @ F.T."),
            (P + Q, "F is missing: an uncertain heading makes the position uncertain."),
            (F @ P @ F.T - Q, "The sign of Q is wrong: noise adds uncertainty."),
        ),
        "The covariance after a motion is F P F^T + Q.",
    )
    yield (
        "innovation",
        "4",
        H @ P @ H.T + R,
        "the covariance",
        (
            (H @ P @ H.T, "R is missing: the measurement has noise, too."),
            (R, "H P H^T is missing: the expectation is uncertain, too."),
            (H @ P @ H.T - R, "The sign of R is wrong: uncertainties add."),
        ),
        "The covariance of the innovation is H P H^T + R.",
    )
    yield (
        "gain",
        "5",
        P @ H.T @ np.linalg.inv(S),
        "the gain",
        (
            (P @ H.T @ S, "S is not inverted: an uncertain measurement must correct less."),
            (P @ H.T, "The inverse of S is missing: an uncertain measurement must correct less."),
            (H.T @ np.linalg.inv(S), "P is missing: an uncertain state is corrected more."),
        ),
        "The gain is P H^T times the inverse of S, np.linalg.inv(S).",
    )
    state, step = np.array(probe.STATE), K @ probe.INNOVATION
    yield (
        "state",
        "7",
        state + step,
        "the state",
        (
            (state - step, "The sign is wrong: the innovation is measurement minus expectation."),
            (state, "The innovation is missing: the state changes by K @ innovation."),
        ),
        "The corrected state is state + K @ innovation.",
    )
    turned = np.array([0.0, 0.0, 3.1, 0.0, 0.0]) - step
    wrapped = turned.copy()
    wrapped[2] -= 2.0 * math.pi
    yield ("wrapped", "7", wrapped, "the state", ((turned, _WRAPPED),), _WRAPPED)
    A = np.eye(5) - K @ H
    noise = K @ R @ K.T
    yield (
        "covariance",
        "8",
        A @ P @ A.T + noise,
        "the covariance",
        (
            (
                A @ P,
                "This is the short form: the covariance is not symmetric with any other gain than "
                "the exact one, and rounding makes each gain another one.",
            ),
            (
                A @ P @ A.T,
                "K R K^T is missing: without the noise of the measurement the filter becomes too "
                "sure, and then ignores GNSS.",
            ),
            (A @ P @ A + noise, "The second A must be transposed: else it is not symmetric."),
            (A @ P @ A.T - noise, "The sign of K R K^T is wrong: noise adds uncertainty."),
            (P, "The covariance does not change: a measurement makes the filter surer."),
        ),
        "The form of Joseph is A P A^T + K R K^T with A = I - K H.",
    )


class LocalizerSubject(LocalizationSubject):
    """localizer.py, TODO 9."""

    module = "localizer"
    todos = ("9",)

    def _problems(self, found: dict) -> Iterator[Problem]:
        wanted, got = list(probe.HEADINGS), found["headings"]
        if same(got, wanted):
            return
        typical = (
            ([math.degrees(one) for one in wanted], "These are degrees; angles are in radians."),
            (
                [math.atan2(math.cos(one), math.sin(one)) for one in wanted],
                "The two arguments of math.atan2 are swapped: it is atan2(dy, dx).",
            ),
            (
                [math.atan2(-math.sin(one), -math.cos(one)) for one in wanted],
                "It points backwards: the direction is next waypoint minus waypoint.",
            ),
            (
                [math.atan(math.tan(one)) for one in wanted],
                "atan returns only half of the directions; atan2(dy, dx) returns all.",
            ),
            ([-one for one in wanted], "The sign is wrong: angles grow counter-clockwise."),
        )
        law = "The direction from (x, y) to (x', y') is math.atan2(y' - y, x' - x)."
        yield Problem(f"the headings {shown(wanted)}", shown(got), hint_for(got, typical, law), "9")


class OdometryMessageSubject(LocalizationSubject):
    """odometry_message.py, TODO 10."""

    module = "odometry_message"
    todos = ("10",)

    def _problems(self, found: dict) -> Iterator[Problem]:
        wanted, got = _placed((0, 1, 5)), found["covariance"]
        if same(got, wanted):
            return
        diagonal = np.diag(np.diag(probe.COVARIANCE))
        typical = (
            (
                _placed((0, 1, 2)),
                "The variance of yaw is at the place of z: yaw is the last of the six coordinates.",
            ),
            (_placed((0, 1, 5), diagonal), "Only the variances are there: x, y and yaw correlate."),
            (_placed((0, 1, 3)), "The variance of yaw is at the place of roll."),
            ([0.0] * 36, "Nothing is assigned: all elements are 0, as if the filter were sure."),
        )
        law = "Rows and columns 0, 1 and 5 are x, y and yaw: rows[np.ix_(indices, indices)] = ..."
        seen = f"elements {[i for i, one in enumerate(got) if one]} are not 0" if got else "nothing"
        expected = f"elements {[i for i, one in enumerate(wanted) if one]} are not 0"
        yield Problem(f"36 numbers, of which {expected}", seen, hint_for(got, typical, law), "10")


class LandmarksSubject(LocalizationSubject):
    """landmarks.py, TODO 11 and 12."""

    module = "landmarks"
    todos = ("11", "12")

    def _problems(self, found: dict) -> Iterator[Problem]:
        for name, yaw, dx, dy in (("left", 0.5, 3.0, 4.0), ("behind", 3.0, -3.0, -1.0)):
            direction, got = math.atan2(dy, dx), found[name]
            wanted = [math.hypot(dx, dy), _wrapped(direction - yaw)]
            if same(got, wanted):
                continue
            typical = (
                ([wanted[0], direction - yaw], _WRAPPED),
                ([wanted[0], direction], "The heading is not subtracted: the lidar turns along."),
                ([wanted[0], -wanted[1]], "The sign of the bearing is wrong: positive is left."),
                ([wanted[0] ** 2, wanted[1]], "The root is missing: use math.hypot."),
                (
                    [wanted[0], math.degrees(direction - yaw)],
                    "These are degrees; all angles are in radians.",
                ),
            )
            law = "The range is hypot(dx, dy), the bearing atan2(dy, dx) minus the heading."
            yield Problem(
                f"range and bearing {shown(wanted)}", shown(got), hint_for(got, typical, law), "11"
            )
            break
        yield from self._jacobian_problems(found["jacobian"])

    def _jacobian_problems(self, got: Any) -> Iterator[Problem]:
        from sdc_localization.landmarks import measurement_jacobian

        wanted = measurement_jacobian(np.array(probe.STATE), 4.0, 6.0)
        for row, name, law in (
            (0, "range", "By x it is -dx / root, by y -dy / root."),
            (1, "bearing", "By x it is dy / square, by y -dx / square, by the heading -1."),
        ):
            one, right = [float(value) for value in got[row]], wanted[row].tolist()
            if same(one, right):
                continue
            if all(abs(abs(a) - abs(b)) < 1e-9 for a, b in zip(one, right)):
                law = f"A sign of the derivatives of the {name} is wrong. {law}"
            yield Problem(f"derivatives of the {name} {shown(right)}", shown(one), law, "12")
            return


def _wrapped(angle: float) -> float:
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def _placed(indices: tuple, covariance: np.ndarray = probe.COVARIANCE) -> list:
    rows = np.zeros((6, 6))
    rows[np.ix_(indices, indices)] = covariance
    return rows.ravel().tolist()


LOCALIZATION_SUBJECTS = (
    MotionModelSubject(),
    KalmanFilterSubject(),
    LocalizerSubject(),
    OdometryMessageSubject(),
    LandmarksSubject(),
)
