"""The kinematic controller: exact linearization of a rolling car in the coordinates of its path.

Reference: A. De Luca, G. Oriolo and C. Samson, Feedback Control of a Nonholonomic Car-like Robot,
in J.-P. Laumond (ed.), Robot Motion Planning and Control, Springer 1998 (chained form in path
coordinates, and its control for path following). It is the kinematic controller of J. M. Snider,
CMU-RI-TR-09-08, 2009.

With the path's curvature c at the rear axle's place s, its slope c', the cross-track error d, the
heading error theta, the wheel angle delta and the wheelbase L, the chained form is

    x1 = s x2 = -c' d tan(theta) - c (1 - d c) (1 + sin^2 theta) / cos^2 theta + (1 - d c)^2
    tan(delta) / (L cos^3 theta) x3 = (1 - d c) tan(theta) x4 = d

with dx4 = x3 dx1, dx3 = x2 dx1, dx2 = u2 dt. The feedback dx2/dx1 = -k1 x4 - k2 x3 - k3 x2 reduces
the error over the distance driven, at any speed. The reference turns u2 into a rate of the
steering. Because this car's wheels follow their command, the controller integrates x2 instead and
solves its definition for delta. It needs neither a clock nor the second derivative of the
curvature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from sdc_common.geometry.angles import wrap_angle
from sdc_common.validation import check_non_negative, check_positive
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles, axle_path
from sdc_package.steering.method import Steering, predicted_pose

# The rear axle's path is computed up to this distance ahead of the car's centre.
_PATH_AHEAD_M = 6.0
# The car moves less than this between two calls, unless it is moved to another place.
_MAX_STEP_M = 5.0
# Path coordinates are singular for a car across the path, or at the centre of its bend. The cube of
# the cosine removes the steering long before a right angle, so that greater errors count as this
# one.
_MAX_HEADING_ERROR_RAD = 0.8
_MIN_SCALE = 0.3
# x2 is the curvature beyond that of the path, and no car drives a tighter bend.
_MAX_EXCESS_CURVATURE = 0.3


@dataclass
class ChainedForm:
    """The controller in path coordinates."""

    wheelbase_m: float  # distance between the axles [m]
    x2: float = 0.0  # state of the chained form, the curvature beyond that of the path [1/m]

    def wheel_angle(
        self,
        driven_m: float,
        cross_track_m: float,
        heading_error_rad: float,
        curvature: float,
        curvature_slope: float,
        k: float,
    ) -> float:
        """Return the front wheel angle, positive left [rad].

        Args:
            driven_m: distance driven since the last call [m]
            cross_track_m: lateral offset of the rear axle, positive left of the path [m]
            heading_error_rad: direction in which the rear axle moves minus heading of the path
                [rad]
            curvature: curvature of the path [1/m]
            curvature_slope: change of the curvature per distance [1/m^2]
            k: all three poles of the error are at -k, so that k1 = k^3, k2 = 3 k^2, k3 = 3 k [1/m]
        """
        theta = min(max(heading_error_rad, -_MAX_HEADING_ERROR_RAD), _MAX_HEADING_ERROR_RAD)
        scale = max(_MIN_SCALE, 1.0 - cross_track_m * curvature)
        cos, tan = math.cos(theta), math.tan(theta)
        x3 = scale * tan
        goal = -(k * k * cross_track_m + 3.0 * k * x3) / 3.0
        self.x2 = goal + (self.x2 - goal) * math.exp(-3.0 * k * driven_m * cos / scale)
        self.x2 = min(max(self.x2, -_MAX_EXCESS_CURVATURE), _MAX_EXCESS_CURVATURE)
        bend = self.x2 + curvature_slope * cross_track_m * tan
        bend += curvature * scale * (1.0 + math.sin(theta) ** 2) / (cos * cos)
        return math.atan(self.wheelbase_m * cos**3 * bend / (scale * scale))


@dataclass(eq=False)
class KinematicSteering(Steering):
    """The kinematic controller, at the rear axle, while the car's centre follows the route.

    The slip of the tyres is compensated. The error decreases over `convergence_m + convergence_s *
    speed`. A constant distance would demand ever faster steering as the speed grows.
    """

    axles: Axles  # geometry and tyres of the car
    convergence_m: float  # distance over which an error decreases at standstill [m]
    convergence_s: float  # additional distance per speed [s]
    preview_s: float  # delay over which the pose is predicted [s]

    def __post_init__(self):
        check_positive(convergence_m=self.convergence_m)
        check_non_negative(convergence_s=self.convergence_s, preview_s=self.preview_s)
        self.form = ChainedForm(self.axles.wheelbase_m)
        self._last_xy: tuple[float, float] | None = None

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
        centre_s = path.line.nearest(x, y).s_m
        count = path.line.count_until(centre_s + _PATH_AHEAD_M)
        rear = axle_path(path.line, count, speed_mps, axles, -axles.rear_m)
        place = rear.nearest(x - axles.rear_m * math.cos(yaw), y - axles.rear_m * math.sin(yaw))
        curvature = rear.curvature_at(place.s_m)
        slope = 0.5 * (rear.curvature_at(place.s_m + 1.0) - rear.curvature_at(place.s_m - 1.0))
        acceleration = curvature * speed_mps * speed_mps
        heading_error = wrap_angle(yaw - axles.rear_compliance * acceleration - place.heading_rad)
        errors, driven_m = (place.cross_track_m, heading_error), self._driven_m(x_m, y_m, yaw_rad)
        k = 1.0 / (self.convergence_m + self.convergence_s * speed_mps)
        angle = self.form.wheel_angle(driven_m, *errors, curvature, slope, k)
        return angle + axles.understeer_gradient * acceleration

    def _driven_m(self, x_m: float, y_m: float, yaw_rad: float) -> float:
        """Return how far the car has moved forward since the last call [m]."""
        last, self._last_xy = self._last_xy, (x_m, y_m)
        if last is None or math.dist(last, (x_m, y_m)) > _MAX_STEP_M:
            self.form.x2 = 0.0
            return 0.0
        return max(0.0, (x_m - last[0]) * math.cos(yaw_rad) + (y_m - last[1]) * math.sin(yaw_rad))
