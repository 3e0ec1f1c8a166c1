"""The kinematic controller: exact linearisation of a car that rolls without slipping, in the coordinates of its path.

Source: A. De Luca, G. Oriolo and C. Samson, Feedback Control of a Nonholonomic Car-like Robot, in J.-P. Laumond (ed.), Robot Motion
Planning and Control, Springer 1998 (chained form in path coordinates, and its control for path following); it is the
kinematic controller of J. M. Snider, CMU-RI-TR-09-08, 2009.

With c the path's curvature at the rear axle's place s on it, c' its slope, d the cross-track error, theta the heading error, delta the
wheel angle and L the wheelbase, the chained form is

    x1 = s    x2 = -c' d tan(theta) - c (1 - d c) (1 + sin^2 theta) / cos^2 theta + (1 - d c)^2 tan(delta) / (L cos^3 theta)
    x3 = (1 - d c) tan(theta)    x4 = d

with dx4 = x3 dx1, dx3 = x2 dx1, dx2 = u2 dt. The feedback dx2/dx1 = -k1 x4 - k2 x3 - k3 x2 makes the error die out over the distance
driven, at any speed. The source turns u2 into a rate of the steering. As the car's steering goes where it is told, the same is had
by carrying x2 along and solving its definition for delta: no clock and no second derivative of the road is needed.
"""

from __future__ import annotations

import math

from sdc_common.geometry.angles import wrap_angle
from sdc_common.validation import check_non_negative, check_positive
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles, rear_axle_path
from sdc_package.steering.method import Steering, predicted_pose

_LOOK_AT_M = 6.0
# A car moves less than this between two calls; one that moves more was picked up and put elsewhere.
_LONGEST_STEP_M = 5.0
# Where the path coordinates end: a car across the path, or in the centre of its bend. The cube of the cosine lets go of the steering
# long before a right angle, so that greater heading errors count as this one.
_MOST_HEADING_ERROR_RAD = 0.8
_LEAST_SCALE = 0.3
# No steering drives a bend tighter than this, and x2 is the curvature in excess of the path's.
_MOST_EXCESS_CURVATURE = 0.3


class ChainedForm:
    """The controller proper. `k` in 1/m: the error's three poles all lie at -k a metre, so that k1 = k^3, k2 = 3 k^2, k3 = 3 k."""

    def __init__(self, wheelbase_m: float):
        self.wheelbase_m = wheelbase_m
        self.x2 = 0.0

    def wheel_angle(
        self,
        driven_m: float,
        cross_track_m: float,
        heading_error_rad: float,
        curvature: float,
        curvature_slope: float,
        k: float,
    ) -> float:
        """Front wheel angle in radians, positive to the left, after `driven_m` metres since the last call.

        cross_track_m is positive to the left of the path, heading_error_rad is the rear axle's direction of motion less the path's;
        curvature in 1/m and curvature_slope in 1/m^2 are the path's.
        """
        theta = min(max(heading_error_rad, -_MOST_HEADING_ERROR_RAD), _MOST_HEADING_ERROR_RAD)
        scale = max(_LEAST_SCALE, 1.0 - cross_track_m * curvature)
        cos, tan = math.cos(theta), math.tan(theta)
        x3 = scale * tan
        goal = -(k * k * cross_track_m + 3.0 * k * x3) / 3.0
        self.x2 = goal + (self.x2 - goal) * math.exp(-3.0 * k * driven_m * cos / scale)
        self.x2 = min(max(self.x2, -_MOST_EXCESS_CURVATURE), _MOST_EXCESS_CURVATURE)
        bend = (
            self.x2
            + curvature_slope * cross_track_m * tan
            + curvature * scale * (1.0 + math.sin(theta) ** 2) / (cos * cos)
        )
        return math.atan(self.wheelbase_m * cos**3 * bend / (scale * scale))


class KinematicSteering(Steering):
    """The kinematic controller at the rear axle, along the path that it takes when the car's centre follows the route, with the
    tyres' slip reckoned in.

    Figures: the error dies out over `convergence_m` + speed times `convergence_s` (each pole's distance; a constant distance
    would ask ever more of the steering as the car gets faster); `preview_s`, how far ahead in time the pose is predicted.
    """

    def __init__(self, axles: Axles, convergence_m: float, convergence_s: float, preview_s: float):
        check_positive(convergence_m=convergence_m)
        check_non_negative(convergence_s=convergence_s, preview_s=preview_s)
        self.axles = axles
        self.convergence_m = convergence_m
        self.convergence_s = convergence_s
        self.preview_s = preview_s
        self.form = ChainedForm(axles.wheelbase_m)
        self._last = None

    def wheel_angle(
        self,
        path: ReferencePath,
        x_m: float,
        y_m: float,
        yaw_rad: float,
        speed_mps: float,
        yaw_rate_radps: float = 0.0,
    ) -> float:
        """See Steering.wheel_angle."""
        axles = self.axles
        x, y, yaw = predicted_pose(x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps, self.preview_s)
        centre_s = path.line.nearest(x, y)[2]
        rear = rear_axle_path(
            path.line, path.line.count_until(centre_s + _LOOK_AT_M), speed_mps, axles
        )
        _, _, s, cross_track, heading = rear.nearest(
            x - axles.rear_m * math.cos(yaw), y - axles.rear_m * math.sin(yaw)
        )
        curvature = rear.curvature_at(s)
        slope = 0.5 * (rear.curvature_at(s + 1.0) - rear.curvature_at(s - 1.0))
        acceleration = curvature * speed_mps * speed_mps
        heading_error = wrap_angle(yaw - axles.rear_compliance * acceleration - heading)
        angle = self.form.wheel_angle(
            self._driven(x_m, y_m, yaw_rad),
            cross_track,
            heading_error,
            curvature,
            slope,
            1.0 / (self.convergence_m + self.convergence_s * speed_mps),
        )
        return angle + axles.understeer_gradient * acceleration

    def _driven(self, x_m: float, y_m: float, yaw_rad: float) -> float:
        """Metres that the car moved forward since the last call."""
        last, self._last = self._last, (x_m, y_m)
        if last is None or math.dist(last, (x_m, y_m)) > _LONGEST_STEP_M:
            self.form.x2 = 0.0
            return 0.0
        return max(0.0, (x_m - last[0]) * math.cos(yaw_rad) + (y_m - last[1]) * math.sin(yaw_rad))
