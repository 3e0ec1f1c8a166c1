"""Stanley steering in its textbook form.

Reference: G. M. Hoffmann, C. J. Tomlin, M. Montemerlo and S. Thrun, Autonomous Automobile
Trajectory Tracking for Off-Road Driving, American Control Conference 2007, equation 5 and section
III.B.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from sdc_common.geometry.angles import wrap_angle
from sdc_common.validation import check_non_negative, check_positive
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles
from sdc_package.steering.method import Steering


def stanley_angle(
    heading_error_rad: float,
    cross_track_m: float,
    speed_mps: float,
    k: float,
    softening_mps: float = 0.0,
) -> float:
    """Return the front wheel angle of Stanley's control law (Hoffmann 2007, equation 5).

    Args:
        heading_error_rad: heading of the path minus heading of the car [rad]
        cross_track_m: lateral offset of the front axle, positive left of the path [m]
        speed_mps: speed [m/s]
        k: gain that turns cross-track error into an angle [1/s]
        softening_mps: keeps that angle small at low speed [m/s]

    Returns:
        wheel angle, positive left [rad]
    """
    # TODO 2.7: the heading error, and an angle that grows with the offset (until then: return 0.0)
    return heading_error_rad - math.atan2(k * cross_track_m, softening_mps + abs(speed_mps))
    # ----------------------------------------------------------------------------


@dataclass(eq=False)
class StanleySteering(Steering):
    """Stanley's law at the front axle, as in the paper."""

    axles: Axles  # geometry of the car
    k: float  # gain of the cross-track error [1/s]
    softening_mps: float  # keeps the steering calm at low speed [m/s]

    def __post_init__(self):
        check_positive(k=self.k)
        check_non_negative(softening_mps=self.softening_mps)

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
        front_x = x_m + self.axles.front_m * math.cos(yaw_rad)
        front_y = y_m + self.axles.front_m * math.sin(yaw_rad)
        place = path.line.nearest(front_x, front_y)
        errors = wrap_angle(place.heading_rad - yaw_rad), place.cross_track_m
        return stanley_angle(*errors, speed_mps, self.k, self.softening_mps)
