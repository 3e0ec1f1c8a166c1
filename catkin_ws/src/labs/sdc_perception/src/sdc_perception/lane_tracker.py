"""Track the lane ahead over time: a clothoid spline in the frame of the odometry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from sdc_common.geometry.angles import wrap_angle
from sdc_common.validation import check_positive
from sdc_perception.lane_acquisition import LaneGuess
from sdc_perception.lane_curve import KNOT_M, POINTS_PER_KNOT, LaneCurve
from sdc_perception.marking_search import Markings, MarkingSearch, View
from sdc_perception.robust_fit import correction, robust_weights
from sdc_perception.vehicle_frame import in_vehicle_frame

LEFT, RIGHT = "left", "right"

_BEHIND_M = 6.0
# Share of the excess over `lasting_1pm` that is left one knot ahead.
_STRAIGHTENING = 0.6
# The car is within this arc length of the anchor. Farther ahead, a lane of which only a tight bend
# is known can lead back to the car.
_CAR_WITHIN_M = 15.0
_KNOTS = 17
_STATES = _KNOTS + 2
_FIRST_PROFILE_M = 2.0
_PROFILE_STEP = 2  # points of the curve from one profile to the next
_SWEEPS = 3
_NARROWEST_GATE_M = 0.12
# Profiles without a marking after which those ahead do not count, and after which they count only
# where two lines are visible at once: a crossing interrupts the lines of a road.
_SHORT_GAP, _LONG_GAP = 3, 10
# A marking counts if a marking of a neighbouring profile continues it.
_NEIGHBOURS = 3  # greatest distance of that profile, in profiles
_ASIDE_M = 0.08  # greatest distance of that marking to a side
_ASIDE_M_PER_PROFILE = 0.12  # increase of that distance for each profile between them
# Neighbouring profiles cross the same piece of a line: their errors are not independent.
_INDEPENDENT = 0.5
_NEAR_M = 4.0
# Markings so far to the other side belong to the road that leaves there.
_KEPT_M = 0.2
# Where the car begins to keep to one side, the bend still has one curvature so far ahead.
_SAME_BEND_M = 4.0


@dataclass(frozen=True)
class LaneSettings:
    """Dimensions of the road, and the noise that the tracker assumes; all positive."""

    lane_width_m: float  # width of a lane [m]
    start_m: float  # standard deviation of the offset at the start [m]
    start_rad: float  # of the heading at the start [rad]
    start_1pm: float  # of the curvature at the start [1/m]
    knot_1pm: float  # of the change of the curvature from a knot to the next [1/m]
    lasting_1pm: float  # greatest curvature of a bend of which no end is expected [1/m]
    kept_1pm: float  # the same while the car keeps to one side where the road divides [1/m]
    drift_m: float  # of the odometry's error across the road, per square root of a metre [m]
    drift_rad: float  # of the odometry's heading error, per square root of a metre [rad]
    drift_1pm: float  # of the error of a curvature ahead, per square root of a metre [1/m]
    # The same, as a share of the change of the curvature from a knot to the next
    drift_share: float
    known_m: float  # deviation of the lane's position up to which it is known without markings [m]
    visible_m: float  # deviation of the lane's position up to which the lane is visible [m]
    lost_m: float  # deviation next to the car at which the confidence is zero [m]

    def __post_init__(self):
        check_positive(**vars(self))

    @property
    def lines_m(self) -> np.ndarray:
        """Return the offsets (3,) of right edge, dashes and left edge from the centre [m]."""
        return self.lane_width_m * np.array([-0.5, 0.5, 1.5])


class TrackedLane(NamedTuple):
    """The lane as the tracker knows it."""

    offset_m: float  # distance of the car to the left of the lane's centre [m]
    heading_error_rad: float  # direction of the lane minus heading of the car [rad]
    curvature_1pm: float  # curvature of the lane next to the car, positive left [1/m]
    confidence: float  # 0..1
    visible_m: float  # distance ahead up to which the lane is known [m]
    first_m: float  # arc length of the first point, measured from the car [m]
    points_m: np.ndarray  # centre of the lane (N, 2) in the frame of the odometry, STEP_M apart [m]
    curvatures_1pm: np.ndarray  # curvatures (N,) of the points [1/m]

    @classmethod
    def of(cls, message: Any) -> TrackedLane:
        """Return the lane of a sdc_perception/Lane.

        Raises:
            ValueError: the points are not a lane
        """
        points, curvatures = np.column_stack([message.x_m, message.y_m]), message.curvatures_1pm
        if not (len(points) == len(curvatures) > 1 and np.isfinite(points).all()):
            raise ValueError("the lane has fewer than two points, or one that is not finite")
        numbers = [getattr(message, name) for name in NUMBERS]
        return cls._make([*numbers, points, np.array(curvatures)])


# Fields of a lane that its message has under the same name.
NUMBERS = TrackedLane._fields[:6]


class FoundMarkings(NamedTuple):
    """Markings of the last picture: points (M, 2) in the vehicle frame [m], and lines (M,) 0..2."""

    points_m: np.ndarray
    line: np.ndarray


def _in_a_line(row: np.ndarray, line: np.ndarray, offset_m: np.ndarray) -> np.ndarray:
    """Return which markings (M,) continue in a neighbouring profile."""
    away = np.abs(row[:, None] - row)
    aside = np.abs(offset_m[:, None] - offset_m)
    neighbours = (line[:, None] == line) & (away > 0) & (away <= _NEIGHBOURS)
    return (neighbours & (aside < _ASIDE_M + _ASIDE_M_PER_PROFILE * away)).any(axis=1)


class LaneTracker:
    """A Kalman filter of the lane's centre line, with robust weights.

    Its state is a LaneCurve. The curve does not move while the car drives along it: new knots are
    added ahead, old ones are removed behind the car, and the uncertainty grows with the drift of
    the odometry.

    Reference: E. D. Dickmanns and B. D. Mysliwetz, Recursive 3-D Road and Relative Ego-State
    Recognition, IEEE Transactions on Pattern Analysis 14(2), 1992: clothoids as a model of the road
    in a Kalman filter. P. J. Huber, Robust Statistics, 1981, section 7.8: iterated weights.

    Attributes:
        curve: the centre of the lane
        covariance: covariance (S, S) of the parameters of `curve`, see LaneCurve.jacobian
        found: the markings of the last picture
    """

    def __init__(
        self,
        search: MarkingSearch,
        settings: LaneSettings,
        pose: tuple[float, float, float],
        guess: LaneGuess,
    ):
        """Start with a lane next to the car.

        Args:
            search: finds the markings
            settings: dimensions and noise
            pose: x [m], y [m] and yaw [rad] of the car in the frame of the odometry
            guess: the lane
        """
        self._search, self._settings = search, settings
        self._keep: str | None = None
        x, y, yaw = pose
        s = -_BEHIND_M
        offset_m, heading_error_rad, curvature_1pm, _ = guess
        across = -offset_m + heading_error_rad * s + 0.5 * curvature_1pm * s * s
        self.curve = LaneCurve(
            x + s * math.cos(yaw) - across * math.sin(yaw),
            y + s * math.sin(yaw) + across * math.cos(yaw),
            yaw + heading_error_rad + curvature_1pm * s,
            np.full(_KNOTS, curvature_1pm),
        )
        at_car = round(_BEHIND_M / KNOT_M)
        # What is known is the lane next to the car: its errors at the anchor depend on each other.
        back = np.zeros((_STATES, 3))
        back[0] = 1.0, -_BEHIND_M, 0.5 * _BEHIND_M**2
        back[1, 1:] = 1.0, -_BEHIND_M
        back[2:, 2] = 1.0
        start = np.diag(np.square([settings.start_m, settings.start_rad, settings.start_1pm]))
        self.covariance = back @ start @ back.T
        self.covariance[2 + at_car + 1 :, 2 + at_car + 1 :] += self._walk(_KNOTS - at_car - 1)
        self.covariance += 1e-10 * np.eye(_STATES)
        self.found = FoundMarkings(np.zeros((0, 2)), np.zeros(0, int))
        self._position = (x, y)
        self._end_s_m = 0.0
        self._searched_beyond = False

    def update(self, views: Sequence[View], keep: str | None = None) -> TrackedLane:
        """Correct the lane with a picture.

        Args:
            views: the newest picture, and earlier ones
            keep: LEFT or RIGHT: the side to keep to where the road divides, or None. The lane then
                continues with its curvature, because the edge of the other side leads away
        """
        pose = views[0].pose
        s_m = self.curve.nearest(*pose[:2], _CAR_WITHIN_M).s_m
        if keep != self._keep:
            self._keep = keep
            known_m = s_m
            if keep is not None:
                known_m += _SAME_BEND_M
                self._even_out(s_m, known_m)
            self._forget_beyond(known_m)
        self._drift(math.dist(self._position, pose[:2]), s_m)
        self._position = pose[:2]
        while s_m > _BEHIND_M + KNOT_M:
            self._advance()
            s_m -= KNOT_M
        prior, prior_inverse = self.covariance, np.linalg.inv(self.covariance)
        moved = np.zeros(_STATES)
        for _ in range(_SWEEPS):
            self.covariance = prior
            moved = moved + self._correct(views, s_m, prior_inverse, moved)
        if self._searched_beyond:
            deviation = self._deviation(self.curve.jacobian())
            known_s_m = self._known_until(s_m, deviation, self._settings.known_m)
            self._forget_beyond(max(self._end_s_m, known_s_m))
        return self._lane(pose)

    def _deviation(self, jacobian: np.ndarray) -> np.ndarray:
        """Return the standard deviations (P,) of the position of points with a jacobian [m]."""
        return np.sqrt(np.sum((jacobian @ self.covariance) * jacobian, axis=1))

    def _known_until(self, s_m: float, deviation_m: np.ndarray, limit_m: float) -> float:
        """Return the arc length after s_m at which the deviation (P,) exceeds a limit [m]."""
        unknown = (self.curve.s_m > s_m) & (deviation_m > limit_m)
        return float(self.curve.s_m[int(np.argmax(unknown)) if unknown.any() else -1])

    def _walk(self, knots: int) -> np.ndarray:
        """Return the covariance of a random walk of the curvature over a number of knots."""
        number = np.arange(1, knots + 1)
        return np.minimum(number[:, None], number) * self._knot_1pm**2

    def _continued(self, curvature_1pm: float, knots: int) -> tuple[np.ndarray, np.ndarray]:
        """Return curvatures of unknown knots after a known one, and their derivatives by it.

        A wide bend continues; a tight one ends soon.
        """
        limit = self._settings.lasting_1pm
        lasting = min(max(curvature_1pm, -limit), limit)
        share = _STRAIGHTENING ** np.arange(1, knots + 1)
        curvatures = lasting + share * (curvature_1pm - lasting)
        return curvatures, np.ones(knots) if lasting == curvature_1pm else share

    @property
    def _knot_1pm(self) -> float:
        return self._settings.knot_1pm if self._keep is None else self._settings.kept_1pm

    def _drift(self, moved_m: float, s_m: float) -> None:
        """Add the error of the odometry over a distance, and that of the curvature ahead.

        The error of the odometry turns the lane around the car. From far away, a bend is seen less
        well than the tracker assumes, most of all where it begins and ends.
        """
        settings = self._settings
        turn = np.zeros(_STATES)
        turn[:2] = -s_m, 1.0
        steps = np.abs(np.diff(self.curve.curvatures_1pm))
        change = np.maximum(np.append(steps, 0.0), np.append(0.0, steps))
        ahead = KNOT_M * np.arange(_KNOTS) >= s_m
        noise = np.zeros(_STATES)
        noise[0] = settings.drift_m**2
        noise[2:] = ahead * (settings.drift_1pm + settings.drift_share * change) ** 2
        drift = np.diag(noise) + settings.drift_rad**2 * np.outer(turn, turn)
        self.covariance = self.covariance + moved_m * drift

    def _advance(self) -> None:
        """Move the anchor to the next knot, and add a knot at the end."""
        curve, step = self.curve, POINTS_PER_KNOT
        transition = np.zeros((_STATES, _STATES))
        transition[0] = curve.jacobian()[step]
        transition[1] = curve.turns[step]
        transition[np.arange(2, _STATES - 1), np.arange(3, _STATES)] = 1.0
        last, share = self._continued(float(curve.curvatures_1pm[-1]), 1)
        transition[-1, -1] = share[0]
        self.covariance = transition @ self.covariance @ transition.T
        self.covariance[-1, -1] += self._knot_1pm**2
        curvatures = np.append(curve.curvatures_1pm[1:], last)
        x, y = curve.points_m[step].tolist()
        self.curve = LaneCurve(x, y, float(curve.headings_rad[step]), curvatures)

    def _even_out(self, from_m: float, to_m: float) -> None:
        """Correct the curve with the knowledge that it has nearly one curvature between two places.

        A single knot is known less well than the mean of some, and the lane continues with it.
        """
        knots = np.arange(2 + int(from_m / KNOT_M), 2 + int(math.ceil(to_m / KNOT_M)))
        change = np.zeros((len(knots), _STATES))
        change[np.arange(len(knots)), knots] = -1.0
        change[np.arange(len(knots)), knots + 1] = 1.0
        steps = np.diff(self.curve.curvatures_1pm)[knots - 2]
        spread = change @ self.covariance @ change.T + self._knot_1pm**2 * np.eye(len(knots))
        gain = np.linalg.solve(spread, change @ self.covariance).T
        self.curve = self.curve.moved(-gain @ steps)
        self.covariance = self.covariance - gain @ change @ self.covariance

    def _forget_beyond(self, s_m: float) -> None:
        """Continue with the curvature at an arc length, because no marking beyond fits."""
        last = int(math.ceil(s_m / KNOT_M))
        if last >= _KNOTS - 1:
            return
        transition = np.eye(_STATES)
        transition[2 + last + 1 :] = 0.0
        curve = self.curve
        continued, share = self._continued(float(curve.curvatures_1pm[last]), _KNOTS - last - 1)
        transition[2 + last + 1 :, 2 + last] = share
        self.covariance = transition @ self.covariance @ transition.T
        self.covariance[2 + last + 1 :, 2 + last + 1 :] += self._walk(_KNOTS - last - 1)
        curvatures = curve.curvatures_1pm.copy()
        curvatures[last + 1 :] = continued
        self.curve = LaneCurve(curve.x_m, curve.y_m, curve.heading_rad, curvatures)

    def _correct(
        self,
        views: Sequence[View],
        s_m: float,
        prior_inverse: np.ndarray,
        moved: np.ndarray,
    ) -> np.ndarray:
        """Correct the curve once with the markings near it; return its change (S,)."""
        curve = self.curve
        first = int(np.searchsorted(curve.s_m, s_m + _FIRST_PROFILE_M))
        rows = np.arange(first, len(curve.s_m), _PROFILE_STEP)
        jacobian = curve.jacobian()[rows]
        deviation = self._deviation(jacobian)
        markings, inside = self._find(views, rows, deviation)
        row, line = markings.row % len(rows), markings.row // len(rows)
        supports = (
            np.abs(markings.offset_m) < 3.0 * np.hypot(deviation[row], markings.deviation_m) + 0.1
        )
        if self._keep is not None:
            side, edge = (1.0, 0) if self._keep == LEFT else (-1.0, 2)
            supports &= (side * markings.offset_m > -_KEPT_M) & (line != edge)
        else:
            supports &= _in_a_line(row, line, markings.offset_m)
        end = self._contiguous(np.bincount(row[supports], minlength=len(rows)))
        self._end_s_m = float(curve.s_m[rows[end]]) if end >= 0 else s_m
        self._searched_beyond = bool(inside[::2].any(axis=0)[end + 1 : end + 5].any())

        used = (row <= end) & supports
        residual, sigma, row = markings.offset_m[used], markings.deviation_m[used], row[used]
        scale = 2.0 * np.hypot(sigma, np.hypot(deviation[row], 0.04))
        weight = _INDEPENDENT * robust_weights(residual, sigma, scale)
        change, covariance = correction(prior_inverse, jacobian[row], weight, residual, moved)
        self.covariance = 0.5 * (covariance + covariance.T)
        self.curve = curve.moved(change)
        return change

    def _find(
        self, views: Sequence[View], rows: np.ndarray, deviation_m: np.ndarray
    ) -> tuple[Markings, np.ndarray]:
        """Search along the normals of all lines at some points of the curve.

        Returns:
            the markings, numbered line by line, and the mask (3, R) of the searched profiles
        """
        left, centre = self.curve.left[rows], self.curve.points_m[rows]
        points = (centre + self._settings.lines_m[:, None, None] * left).reshape(-1, 2)
        normals, gates = np.tile(left, (3, 1)), np.tile(deviation_m, 3)
        gates = np.hypot(gates, _NARROWEST_GATE_M)
        if self._keep is not None:
            gates = np.minimum(gates, _KEPT_M)
        markings, inside = self._search.find(views, points, normals, gates)
        found_m = points[markings.row] + markings.offset_m[:, None] * normals[markings.row]
        self.found = FoundMarkings(
            in_vehicle_frame(found_m, views[0].pose), markings.row // len(rows)
        )
        return markings, inside.reshape(3, -1)

    def _contiguous(self, count: np.ndarray) -> int:
        """Return the last profile up to which markings follow each other, -1 for none.

        Args:
            count: number of lines (R,) with a marking that supports the prediction
        """
        if self._keep is not None:  # at the mouth of the other road are no lines
            return int(np.max(np.flatnonzero(count), initial=-1))
        end = -1
        for i in np.flatnonzero(count).tolist():
            gap = i - end - 1
            isolated = end >= 0 and count[i : i + 3].sum() < 4
            if gap > _LONG_GAP or (gap > _SHORT_GAP and isolated):
                break
            end = i
        return end

    def _lane(self, pose: tuple[float, float, float]) -> TrackedLane:
        curve, settings = self.curve, self._settings
        place = curve.nearest(*pose[:2], _CAR_WITHIN_M)
        deviation = self._deviation(curve.jacobian())
        near = deviation[int(np.searchsorted(curve.s_m[:-1], place.s_m + _NEAR_M))]
        return TrackedLane(
            place.offset_m,
            wrap_angle(place.heading_rad - pose[2]),
            float(curve.curvature_at(place.s_m)),
            float(np.clip(1.0 - near / settings.lost_m, 0.0, 1.0)),
            self._known_until(place.s_m, deviation, settings.visible_m) - place.s_m,
            -place.s_m,
            curve.points_m,
            curve.curvature_at(curve.s_m),
        )
