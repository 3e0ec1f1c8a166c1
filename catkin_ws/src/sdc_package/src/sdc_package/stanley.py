"""Stanley steering: the front wheels point along the path and lean towards it.

Source: G. M. Hoffmann, C. J. Tomlin, M. Montemerlo and S. Thrun, Autonomous Automobile Trajectory Tracking for Off-Road
Driving, American Control Conference 2007, equation 5 (the law) and section III.B (softening at low speed).
"""
from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass

from sdc_package.local_path import LocalPath, Polyline
from sdc_package.route import wrap_angle

# A piece of path this long ahead of the car holds the front axle's nearest point, whatever the error.
_LOOK_AT_M = 12.0
# A car on its tyres turns no faster; a pose that was set anew, or a jump of the odometry, seems to.
_FASTEST_YAW_RATE_RADPS = 1.5


@dataclass(frozen=True)
class StanleyGains:
    """`k` in 1/s turns cross-track error into an angle; `softening_mps` keeps the angle small at walking speed;
    `preview_s` is how far ahead in time the pose is predicted, to make up for the delay of computer and steering."""

    k: float
    softening_mps: float
    preview_s: float


@dataclass(frozen=True)
class Axles:
    """Distances in metres from the car's centre, the point that follows the path, to its axles, and their cornering
    compliances: the tyres' slip angle a unit of lateral acceleration, rad/(m/s^2)."""

    front_m: float
    rear_m: float
    front_compliance: float
    rear_compliance: float

    def __post_init__(self):
        if not (self.front_m > 0.0 and self.rear_m > 0.0):
            raise ValueError(f"both axles lie away from the centre, got {self}")
        if not (self.front_compliance >= 0.0 and self.rear_compliance >= 0.0):
            raise ValueError(f"a cornering compliance is not negative, got {self}")


def stanley_angle(heading_error_rad: float, cross_track_m: float, speed_mps: float, gains: StanleyGains) -> float:
    """Steering angle in radians, positive to the left (Hoffmann 2007, equation 5).

    heading_error_rad is the path's heading less the car's; cross_track_m is positive when the front axle is to the left of the path.
    """
    return heading_error_rad - math.atan2(gains.k * cross_track_m, gains.softening_mps + abs(speed_mps))


def front_axle_path(line: Polyline, count: int, speed_mps: float, axles: Axles) -> Polyline:
    """The line that the front axle follows while the car's centre follows the first `count` points of `line`.

    In a bend the front axle runs outside of the centre: steering the front axle along the centre's path would make the car cut
    the corner, by 0.9 m in a bend of 4 m radius. The slip angle u between path and car at the centre obeys
    du/ds = curvature - sin(u) / rear_m (kinematic bicycle; R. Rajamani, Vehicle Dynamics and Control, 2nd ed., section 2.2); here
    it is advanced from point to point with the solution for constant curvature. At speed the rear tyres slip outwards and turn the
    car back into the bend, by their compliance times the lateral acceleration (the same, section 3.1).
    """
    front = []
    slip = None
    headings = line.headings
    for i in range(count):
        if i > 0:
            length = line.lengths[i - 1]
            steady = math.asin(min(max(axles.rear_m * (headings[i] - headings[i - 1]) / length, -0.95), 0.95))
            if slip is None:
                slip = steady
            slip = steady + (slip - steady) * math.exp(-length * math.cos(steady) / axles.rear_m)
        sideways = 0.0
        if 0 < i < count - 1:
            curvature = (headings[i + 1] - headings[i - 1]) / (line.lengths[i - 1] + line.lengths[i])
            sideways = axles.rear_compliance * curvature * speed_mps * speed_mps
        yaw = headings[i] - (slip or 0.0) + sideways
        x, y = line.points[i]
        front.append((x + axles.front_m * math.cos(yaw), y + axles.front_m * math.sin(yaw)))
    return Polyline(front)


class StanleySteering:
    """Turns a pose and a local path into a wheel angle."""

    def __init__(self, gains: StanleyGains, axles: Axles):
        self.gains = gains
        self.axles = axles

    def wheel_angle(self, path: LocalPath, x_m: float, y_m: float, yaw_rad: float, speed_mps: float,
                    yaw_rate_radps: float = 0.0) -> float:
        """Front wheel angle in radians, positive to the left, for a car whose centre is at (x_m, y_m) in the map frame."""
        ahead_m = speed_mps * self.gains.preview_s
        yaw_rate = min(max(yaw_rate_radps, -_FASTEST_YAW_RATE_RADPS), _FASTEST_YAW_RATE_RADPS)
        yaw = yaw_rad + yaw_rate * self.gains.preview_s
        middle = 0.5 * (yaw_rad + yaw)
        reach_x = x_m + ahead_m * math.cos(middle) + self.axles.front_m * math.cos(yaw)
        reach_y = y_m + ahead_m * math.sin(middle) + self.axles.front_m * math.sin(yaw)
        centre_s = path.line.nearest(x_m, y_m)[2]
        count = max(3, bisect_right(path.line.s, centre_s + ahead_m + _LOOK_AT_M))
        front = front_axle_path(path.line, min(count, len(path.rows)), speed_mps, self.axles)
        piece, _, _, cross_track, heading = front.nearest(reach_x, reach_y)
        curvature = (front.headings[piece + 1] - front.headings[piece]) / front.lengths[piece]
        slip = self.axles.front_compliance * curvature * speed_mps * speed_mps
        return stanley_angle(wrap_angle(heading - yaw), cross_track, speed_mps, self.gains) + slip
