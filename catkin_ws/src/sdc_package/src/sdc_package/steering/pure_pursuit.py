"""Pure pursuit: the rear axle drives the arc to a point of the path some distance ahead.

References: R. C. Coulter, Implementation of the Pure Pursuit Path Tracking Algorithm,
CMU-RI-TR-92-01, 1992. The look-ahead distance is proportional to the speed, as in J. M. Snider,
Automatic Steering Methods for Autonomous Automobile Path Tracking, CMU-RI-TR-09-08, 2009: delta =
atan(2 L sin(alpha) / (k v)).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from sdc_common.geometry.polyline import Polyline
from sdc_common.validation import check_non_negative, check_positive
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles, axle_path
from sdc_package.steering.method import Steering, predicted_pose

# The slip at the look-ahead point depends on the path this far beyond it.
_BEYOND_M = 3.0
# A car almost as far from the line as the look-ahead distance sees no point at that distance.
_MAX_OFFSET_SHARE = 0.95


def pure_pursuit_angle(alpha_rad: float, look_ahead_m: float, wheelbase_m: float) -> float:
    """Return the front wheel angle of the arc from the rear axle to the look-ahead point.

    Args:
        alpha_rad: direction of the point, relative to the motion of the rear axle [rad]
        look_ahead_m: distance of the point [m]
        wheelbase_m: distance between the axles [m]

    Returns:
        wheel angle, positive left [rad]
    """
    return math.atan2(2.0 * wheelbase_m * math.sin(alpha_rad), look_ahead_m)


def look_ahead_point(
    line: Polyline, x_m: float, y_m: float, distance_m: float
) -> tuple[float, float]:
    """Return the point ahead on a line at a straight distance from the car [m].

    The last segment continues beyond its end. If the car is farther from the line than the
    distance, return the point that is this far along the line.

    Args:
        line: the line, which the search follows from the place nearest to the car
        x_m: position of the car [m]
        y_m: position of the car [m]
        distance_m: straight distance from the car [m]

    Raises:
        ValueError: the distance is not positive
    """
    check_positive(distance_m=distance_m)
    start = line.nearest(x_m, y_m)
    if start.distance_m >= _MAX_OFFSET_SHARE * distance_m:
        return line.point_at(start.s_m + distance_m)
    final = len(line.lengths) - 1
    for i, length in enumerate(line.lengths):
        if length == 0.0 or (line.s[i + 1] < start.s_m and i < final):
            continue
        if i == final or math.dist(line.points[i + 1], (x_m, y_m)) >= distance_m:
            return _circle_exit(line.points[i], line.points[i + 1], length, (x_m, y_m), distance_m)
    return line.points[-1]


def _circle_exit(
    start: tuple[float, float],
    end: tuple[float, float],
    length_m: float,
    centre: tuple[float, float],
    radius_m: float,
) -> tuple[float, float]:
    """Return the point at which the segment from start to end leaves a circle."""
    step_x, step_y = (end[0] - start[0]) / length_m, (end[1] - start[1]) / length_m
    offset_x, offset_y = start[0] - centre[0], start[1] - centre[1]
    inward = offset_x * step_x + offset_y * step_y
    power = offset_x * offset_x + offset_y * offset_y - radius_m * radius_m
    along = -inward + math.sqrt(max(0.0, inward * inward - power))
    return start[0] + along * step_x, start[1] + along * step_y


@dataclass(eq=False)
class PurePursuitSteering(Steering):
    """Pure pursuit of the rear axle, while the car's centre follows the route.

    The slip of the tyres is compensated.
    """

    axles: Axles  # geometry and tyres of the car
    look_ahead_s: float  # look-ahead distance per speed, k in the report [s]
    shortest_look_ahead_m: float  # minimum look-ahead distance [m]
    longest_look_ahead_m: float  # maximum look-ahead distance [m]
    preview_s: float  # delay over which the pose is predicted [s]

    def __post_init__(self):
        check_positive(
            look_ahead_s=self.look_ahead_s,
            shortest_look_ahead_m=self.shortest_look_ahead_m,
            longest_look_ahead_m=self.longest_look_ahead_m,
        )
        check_non_negative(preview_s=self.preview_s)
        if self.shortest_look_ahead_m > self.longest_look_ahead_m:
            raise ValueError(
                f"shortest_look_ahead_m {self.shortest_look_ahead_m:g} exceeds "
                f"longest_look_ahead_m {self.longest_look_ahead_m:g}"
            )

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
        least_m, most_m = self.shortest_look_ahead_m, self.longest_look_ahead_m
        look_ahead = min(max(self.look_ahead_s * speed_mps, least_m), most_m)
        x, y, yaw = predicted_pose(x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps, self.preview_s)
        rear_x, rear_y = x - axles.rear_m * math.cos(yaw), y - axles.rear_m * math.sin(yaw)
        centre_s = path.line.nearest(x, y).s_m
        count = path.line.count_until(centre_s + look_ahead + axles.rear_m + _BEYOND_M)
        rear = axle_path(path.line, count, speed_mps, axles, -axles.rear_m)
        goal_x, goal_y = look_ahead_point(rear, rear_x, rear_y, look_ahead)
        acceleration = path.line.curvature_at(centre_s) * speed_mps * speed_mps
        direction = yaw - axles.rear_compliance * acceleration
        alpha = math.atan2(goal_y - rear_y, goal_x - rear_x) - direction
        angle = pure_pursuit_angle(alpha, look_ahead, axles.wheelbase_m)
        return angle + axles.understeer_gradient * acceleration
