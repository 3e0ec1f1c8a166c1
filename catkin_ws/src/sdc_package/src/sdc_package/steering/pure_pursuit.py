"""Pure pursuit: the rear axle drives the arc that leads to a point of the path some way ahead.

Source: R. C. Coulter, Implementation of the Pure Pursuit Path Tracking Algorithm, CMU-RI-TR-92-01, 1992; in the form with a
look-ahead distance proportional to speed of J. M. Snider, Automatic Steering Methods for Autonomous Automobile Path Tracking,
CMU-RI-TR-09-08, 2009, section on pure pursuit: delta = atan(2 L sin(alpha) / (k v)).
"""

from __future__ import annotations

import math

from sdc_common.geometry.polyline import Polyline
from sdc_common.validation import check_non_negative, check_positive
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles, rear_axle_path
from sdc_package.steering.method import Steering, predicted_pose

# Beyond the look-ahead point the path is of no concern, but for the slip at that point.
_BEYOND_M = 3.0


def pure_pursuit_angle(alpha_rad: float, look_ahead_m: float, wheelbase_m: float) -> float:
    """Front wheel angle in radians, positive to the left, of the arc from the rear axle to a point `look_ahead_m` away.

    alpha_rad is the direction of that point less the rear axle's direction of motion.
    """
    return math.atan2(2.0 * wheelbase_m * math.sin(alpha_rad), look_ahead_m)


def look_ahead_point(line: Polyline, x_m: float, y_m: float, distance_m: float):
    """The first point of a line, from the place nearest to (x_m, y_m) on, that is `distance_m` away from it; the last piece reaches
    on beyond its end. A car farther from the line than that looks at the point as far on along the line.

    Returns (x, y) metres. Raises ValueError for a distance that is not positive.
    """
    if not distance_m > 0.0:
        raise ValueError(f"the look-ahead distance must be positive, got {distance_m}")
    _, _, start_s, cross_track, _ = line.nearest(x_m, y_m)
    if abs(cross_track) >= 0.95 * distance_m:
        return line.point_at(start_s + distance_m)
    square = distance_m * distance_m
    final = len(line.lengths) - 1
    for i, length in enumerate(line.lengths):
        if length == 0.0 or (line.s[i + 1] < start_s and i < final):
            continue
        (x, y), (next_x, next_y) = line.points[i], line.points[i + 1]
        away_x, away_y = next_x - x_m, next_y - y_m
        if i < final and away_x * away_x + away_y * away_y < square:
            continue
        step_x, step_y = (next_x - x) / length, (next_y - y) / length
        offset_x, offset_y = x - x_m, y - y_m
        towards = offset_x * step_x + offset_y * step_y
        along = -towards + math.sqrt(
            max(0.0, towards * towards - (offset_x * offset_x + offset_y * offset_y - square))
        )
        return x + along * step_x, y + along * step_y
    return line.points[-1]


class PurePursuitSteering(Steering):
    """Pure pursuit of the rear axle along the path that it takes when the car's centre follows the route, with the tyres' slip
    reckoned in. Figures: `look_ahead_s`, the time ahead (the paper's k); `shortest_look_ahead_m`, `longest_look_ahead_m`;
    `preview_s`, how far ahead in time the pose is predicted."""

    def __init__(
        self,
        axles: Axles,
        look_ahead_s: float,
        shortest_look_ahead_m: float,
        longest_look_ahead_m: float,
        preview_s: float,
    ):
        check_positive(
            look_ahead_s=look_ahead_s,
            shortest_look_ahead_m=shortest_look_ahead_m,
            longest_look_ahead_m=longest_look_ahead_m,
        )
        check_non_negative(preview_s=preview_s)
        if not shortest_look_ahead_m <= longest_look_ahead_m:
            raise ValueError(
                f"shortest_look_ahead_m {shortest_look_ahead_m:g} exceeds longest_look_ahead_m {longest_look_ahead_m:g}"
            )
        self.axles = axles
        self.look_ahead_s = look_ahead_s
        self.shortest_look_ahead_m = shortest_look_ahead_m
        self.longest_look_ahead_m = longest_look_ahead_m
        self.preview_s = preview_s

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
        look_ahead = min(
            max(self.look_ahead_s * speed_mps, self.shortest_look_ahead_m),
            self.longest_look_ahead_m,
        )
        x, y, yaw = predicted_pose(x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps, self.preview_s)
        rear_x, rear_y = x - axles.rear_m * math.cos(yaw), y - axles.rear_m * math.sin(yaw)
        centre_s = path.line.nearest(x, y)[2]
        count = path.line.count_until(centre_s + look_ahead + axles.rear_m + _BEYOND_M)
        rear = rear_axle_path(path.line, count, speed_mps, axles)
        goal_x, goal_y = look_ahead_point(rear, rear_x, rear_y, look_ahead)
        acceleration = path.line.curvature_at(centre_s) * speed_mps * speed_mps
        direction = yaw - axles.rear_compliance * acceleration
        alpha = math.atan2(goal_y - rear_y, goal_x - rear_x) - direction
        return (
            pure_pursuit_angle(alpha, look_ahead, axles.wheelbase_m)
            + axles.understeer_gradient * acceleration
        )
