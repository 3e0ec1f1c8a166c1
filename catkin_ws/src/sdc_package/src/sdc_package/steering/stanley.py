"""Stanley steering: the front wheels point along the path and lean towards it.

Source: G. M. Hoffmann, C. J. Tomlin, M. Montemerlo and S. Thrun, Autonomous Automobile Trajectory Tracking for Off-Road
Driving, American Control Conference 2007, equation 5 (the law) and section III.B (softening at low speed).

The source's yaw damping is left out because it was measured to do harm here: with the slip fed forward, 0.05 s of it turns 0.012 m RMS into
0.016 m on the packaged route (0.025 into 0.030 m at 25 m/s) and takes nothing off the steering's noise.
"""

from __future__ import annotations

import math

from sdc_common.geometry.angles import wrap_angle
from sdc_common.validation import check_non_negative, check_positive
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles, front_axle_path
from sdc_package.steering.method import Steering, predicted_pose

# A piece of path this long ahead of the car holds the front axle's nearest point, whatever the error.
_LOOK_AT_M = 12.0


def stanley_angle(
    heading_error_rad: float,
    cross_track_m: float,
    speed_mps: float,
    k: float,
    softening_mps: float = 0.0,
) -> float:
    """Steering angle in radians, positive to the left (Hoffmann 2007, equation 5).

    heading_error_rad is the path's heading less the car's; cross_track_m is positive when the front axle is to the left of the path;
    k in 1/s turns cross-track error into an angle; softening_mps keeps that angle small at walking speed.
    """
    # TODO 2.7: Stanley's law: along the path, and back to it by an angle that grows with the error (until then: return 0.0)
    return heading_error_rad - math.atan2(k * cross_track_m, softening_mps + abs(speed_mps))
    # ----------------------------------------------------------------------------


class StanleySteering(Steering):
    """Stanley's law along the path that the front axle takes when the car's centre follows the route, with the front tyres' slip
    fed forward. Figures: `k` in 1/s and `softening_mps` as in `stanley_angle`; `preview_s`, how far ahead in time the pose is
    predicted."""

    def __init__(self, axles: Axles, k: float, softening_mps: float, preview_s: float):
        check_positive(k=k)
        check_non_negative(softening_mps=softening_mps, preview_s=preview_s)
        self.axles = axles
        self.k = k
        self.softening_mps = softening_mps
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
        x, y, yaw = predicted_pose(x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps, self.preview_s)
        reach_x = x + self.axles.front_m * math.cos(yaw)
        reach_y = y + self.axles.front_m * math.sin(yaw)
        centre_s = path.line.nearest(x_m, y_m)[2]
        count = path.line.count_until(centre_s + speed_mps * self.preview_s + _LOOK_AT_M)
        front = front_axle_path(path.line, count, speed_mps, self.axles)
        piece, _, _, cross_track, heading = front.nearest(reach_x, reach_y)
        curvature = (front.headings[piece + 1] - front.headings[piece]) / front.lengths[piece]
        slip = self.axles.front_compliance * curvature * speed_mps * speed_mps
        return (
            stanley_angle(
                wrap_angle(heading - yaw), cross_track, speed_mps, self.k, self.softening_mps
            )
            + slip
        )
