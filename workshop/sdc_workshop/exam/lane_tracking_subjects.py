"""Checks of the lab "perception", part two: tracking and following."""

from __future__ import annotations

import math
from typing import Any, Iterator

import numpy as np

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.library_subjects import hint_for, shown
from sdc_workshop.exam.perception_subjects import PICTURE_SUBJECTS, PerceptionSubject
from sdc_workshop.exam.probe import same
from sdc_workshop.exam.probes import perception_probe as probe


class VehicleFrameSubject(PerceptionSubject):
    """vehicle_frame.py, TODO 7."""

    module = "vehicle_frame"
    todos = ("7",)

    def _problems(self, found: dict) -> Iterator[Problem]:
        x, y, yaw = probe.POSE
        c, s = math.cos(yaw), math.sin(yaw)
        turn = np.array([[c, -s], [s, c]])
        away = probe.PLACES - (x, y)
        got, wanted = found["points"], (away @ turn).tolist()
        if same(got, wanted):
            return
        typical = (
            (
                away @ turn.T,
                "It is turned the wrong way: when the car turns to the left, everything moves to "
                "its right.",
            ),
            (away, "It is not turned: x of the result is along the car."),
            (probe.PLACES @ turn, "The position of the car is not subtracted: the car is at 0, 0."),
            (
                probe.PLACES @ turn - (x, y),
                "The order is wrong: subtract the position of the car before you turn.",
            ),
            (-away @ turn, "The sign is wrong: points minus the position of the car."),
        )
        law = "Subtract (x, y), then dx c + dy s is ahead, dy c - dx s to the left."
        hint = hint_for(got, [(value.tolist(), text) for value, text in typical], law)
        place = shown(probe.PLACES[0].tolist())
        text = f"a car at 2, 1 that points along y: the point at {place} is at {shown(wanted[0])}"
        seen = shown(got[0]) if np.shape(got) == np.shape(wanted) else str(got)[:100]
        if seen == shown(wanted[0]):
            text, seen = f"the points {wanted}", f"{got}"
        yield Problem(text, seen, hint, "7")


class RobustFitSubject(PerceptionSubject):
    """robust_fit.py, TODO 8 and 9."""

    module = "robust_fit"
    todos = ("8", "9")

    def _problems(self, found: dict) -> Iterator[Problem]:
        variance, share = np.square(probe.DEVIATIONS), probe.RESIDUALS / probe.SCALES
        wanted, got = (1.0 / variance / (1.0 + share**2)).tolist(), found["weights"]
        if not same(got, wanted):
            typical = (
                (
                    1.0 / variance,
                    "It is not robust: a wrong marking 1 m away has the weight of a right one, and "
                    "pulls the lane to it. Divide by 1 plus the squared share.",
                ),
                (
                    1.0 / probe.DEVIATIONS / (1.0 + share**2),
                    "The weight is 1 / variance, and the variance is the deviation squared.",
                ),
                (
                    1.0 / variance / (1.0 + np.abs(share)),
                    "The share residuals / scales must be squared.",
                ),
                (
                    1.0 / variance / (1.0 + probe.RESIDUALS**2),
                    "scales is not used: at a residual of scales, half of the weight remains.",
                ),
                (1.0 / (1.0 + share**2), "The variance is missing: precise ones weigh more."),
                (variance / (1.0 + share**2), "It is inverted: a precise marking weighs more."),
                (variance * (1.0 + share**2), "It is inverted: a weight is 1 / variance."),
            )
            law = "1 / deviations^2 / (1 + (residuals / scales)^2)."
            hint = hint_for(got, [(value.tolist(), text) for value, text in typical], law)
            yield Problem(f"the weights {shown(wanted)}", shown(got), hint, "8")
        yield from _correction_problems(found["correction"])


def _correction_problems(got: Any) -> Iterator[Problem]:
    P_inverse, J, w = probe.P_INVERSE, probe.JACOBIAN, probe.WEIGHTS
    r, moved = probe.MEASURED, np.array(probe.MOVED)

    def result(P_inverse: np.ndarray, JW: np.ndarray, back: np.ndarray, r: np.ndarray) -> list:
        covariance = np.linalg.inv(P_inverse + JW @ J)
        return [(covariance @ (JW @ r - back)).tolist(), covariance.tolist()]

    weighted, back = (J * w[:, None]).T, P_inverse @ moved
    wanted = result(P_inverse, weighted, back, r)
    if same(got, wanted):
        return
    information = P_inverse + weighted @ J
    typical = (
        (
            result(np.zeros((2, 2)), weighted, back, r),
            "P_inverse is missing in the covariance: there is no smoothing, the prediction does "
            "not count, and the lane jumps from picture to picture.",
        ),
        (
            result(np.zeros((2, 2)), weighted, np.zeros(2), r),
            "P_inverse is missing: there is no smoothing, each picture begins from nothing.",
        ),
        (
            result(P_inverse, J.T, back, r),
            "The weights w are not used: each column of J.T is multiplied by its weight.",
        ),
        (
            result(P_inverse, weighted, np.zeros(2), r),
            "moved is missing: with each sweep over the same picture, the prediction would lose "
            "its weight.",
        ),
        (
            result(P_inverse, weighted, -back, r),
            "The sign of P_inverse @ moved is wrong: it pulls back to the prediction.",
        ),
        (
            result(P_inverse, weighted, back, -r),
            "The sign of the residuals is wrong: they are measured minus predicted values.",
        ),
        (
            [(information @ (weighted @ r - back)).tolist(), information.tolist()],
            "The sum of the weights is not inverted: the more weight, the less uncertainty.",
        ),
        (wanted[::-1], "Return the change first, then the covariance."),
    )
    law = (
        "The covariance is the inverse of P_inverse + J^T W J, the change is the covariance times "
        "(J^T W r - P_inverse moved)."
    )
    seen = shown(np.ravel(got[0]).tolist()) if isinstance(got, list) and got else str(got)
    yield Problem(f"the change {shown(wanted[0])}", seen, hint_for(got, typical, law), "9")


class StampPairingSubject(PerceptionSubject):
    """stamp_pairing.py, TODO 10."""

    module = "stamp_pairing"
    todos = ("10",)

    def _problems(self, found: dict) -> Iterator[Problem]:
        late = (
            "The newest messages are not of the same instant: the picture may be one tick late, "
            "and at 10 m/s the lane is then half a metre away from where it was seen. Take the "
            "messages with this stamp."
        )
        typical = (
            ([2, 13, 23], late),
            ([1, 11, 22], "These are the oldest messages. Take those with this stamp."),
            ([-1], "All three topics have a message with this stamp: return them."),
        )
        law = "One message of each topic, all with stamp_ns, in the order of the topics."
        for name, ticks, wanted, cases in (
            ("together", "1 and 2, 1 to 3, 2 and 3", [2, 12, 22], typical),
            ("picture missing", "1, 1 and 2, 2", [-1], (([1, 12, 22], late),)),
        ):
            got = found[name]
            if got == wanted:
                continue
            what = f"pictures, camera infos and odometry of the ticks {ticks}, asked for tick 2"
            expected = "None" if wanted == [-1] else f"those of tick 2, {wanted}"
            seen = "None" if got == [-1] else str(got)
            yield Problem(f"{what}: {expected}", seen, hint_for(got, cases, law), "10")
            return


class LaneFollowingSubject(PerceptionSubject):
    """lane_following.py, TODO 11 and 12."""

    module = "lane_following"
    todos = ("11", "12")

    def _problems(self, found: dict) -> Iterator[Problem]:
        wanted, got = [min(one) for one in probe.SIGHTS], found["ends"]
        if not same(got, wanted):
            typical = (
                (
                    [lookahead for _, lookahead in probe.SIGHTS],
                    "The sight is ignored: the car drives into what it has not seen.",
                ),
                (
                    [max(one) for one in probe.SIGHTS],
                    "The path ends farther than the lane is known: use min.",
                ),
                ([sight for sight, _ in probe.SIGHTS], "lookahead_m is not used: use min."),
            )
            law = "The lesser one of visible_m and lookahead_m."
            yield Problem(
                f"the ends {shown(wanted)}", shown(got), hint_for(got, typical, law), "11"
            )
        yield from _share_problems(found["shares"])


def _share_problems(got: Any) -> Iterator[Problem]:
    line = (np.array(probe.CONFIDENCES) - 0.2) / (0.6 - 0.2)
    wanted = np.clip(line, 0.0, 1.0)
    if same(got, wanted.tolist()):
        return
    confidences = np.array(probe.CONFIDENCES)
    typical = (
        (
            np.ones(len(line)),
            "The confidence is ignored: the car drives at full speed where it sees nothing.",
        ),
        (line, "It is not limited to 0..1: the car would drive backwards, or faster than planned."),
        (np.minimum(line, 1.0), "It is not limited: below `unsure` it is negative. max(..., 0.0)."),
        (np.maximum(line, 0.0), "It is not limited: above `confident` it is more than 1."),
        (confidences, "unsure and confident are not used: at `unsure` the car stops."),
        (1.0 - wanted, "It is inverted: the more confidence, the faster."),
    )
    law = "0 at `unsure`, 1 at `confident`: (confidence - unsure) / (confident - unsure)."
    hint = hint_for(got, [(value.tolist(), text) for value, text in typical], law)
    what = f"unsure 0.2, confident 0.6, confidence {shown(list(probe.CONFIDENCES))}"
    yield Problem(f"{what}: {shown(wanted.tolist())}", shown(got), hint, "12")


PERCEPTION_SUBJECTS = (
    *PICTURE_SUBJECTS,
    VehicleFrameSubject(),
    RobustFitSubject(),
    StampPairingSubject(),
    LaneFollowingSubject(),
)
