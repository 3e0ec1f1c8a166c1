"""Dead reckoning: the motion of the car from wheel speed and yaw rate."""

from __future__ import annotations

import math

from sdc_common.validation import check_non_negative, check_positive

_LONGEST_STEP_S = 0.5


class DeadReckoning:
    """Pose of the car in a frame that begins at its first pose and drifts.

    The rear axle slips sideways in proportion to the lateral acceleration; the centre of the car
    moves sideways with the yaw rate.

    Attributes:
        x_m: position [m]
        y_m: position [m]
        yaw_rad: heading [rad]
        speed_mps: forward speed [m/s]
        lateral_mps: speed of the centre to the left [m/s]
        yaw_rate_radps: yaw rate [rad/s]
    """

    def __init__(self, rear_m: float, rear_compliance: float):
        """Begin at the origin. The compliance is the slip angle per lateral acceleration."""
        check_positive(rear_m=rear_m)
        check_non_negative(rear_compliance=rear_compliance)
        self._rear_m, self._rear_compliance = rear_m, rear_compliance
        self.x_m = self.y_m = self.yaw_rad = 0.0
        self.speed_mps = self.lateral_mps = self.yaw_rate_radps = 0.0

    def update(self, speed_mps: float, yaw_rate_radps: float, step_s: float) -> None:
        """Move on with the mean of last and new measurement, but not over more than 0.5 s."""
        slip = speed_mps * self._rear_compliance * speed_mps * yaw_rate_radps
        lateral = self._rear_m * yaw_rate_radps - slip
        if 0.0 < step_s <= _LONGEST_STEP_S:
            forward = 0.5 * step_s * (self.speed_mps + speed_mps)
            left = 0.5 * step_s * (self.lateral_mps + lateral)
            turn = 0.5 * step_s * (self.yaw_rate_radps + yaw_rate_radps)
            middle = self.yaw_rad + 0.5 * turn
            self.x_m += forward * math.cos(middle) - left * math.sin(middle)
            self.y_m += forward * math.sin(middle) + left * math.cos(middle)
            self.yaw_rad += turn
        self.speed_mps, self.lateral_mps = speed_mps, lateral
        self.yaw_rate_radps = yaw_rate_radps
