"""What the car does with a command: wheel angle to steer, acceleration to pedals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from sdc_common.validation import check_between, check_non_negative, check_positive, is_number


@dataclass(frozen=True)
class SteeringMap:
    """How the normalised steer command turns the wheels.

    max_wheel_angle_rad: the bicycle-model front wheel angle at full steer and standstill.
    speeds_mps, shares: the share of it that remains at each speed, linear in between, constant beyond.
    """

    max_wheel_angle_rad: float
    speeds_mps: Sequence[float]
    shares: Sequence[float]

    def __post_init__(self):
        check_between(1e-3, 0.499 * math.pi, max_wheel_angle_rad=self.max_wheel_angle_rad)
        for name in ("speeds_mps", "shares"):
            values = getattr(self, name)
            if not (isinstance(values, (list, tuple)) and all(map(is_number, values))):
                raise ValueError(
                    f"{name} of the steering must be a list of numbers, got {values!r}"
                )
        if len(self.speeds_mps) != len(self.shares) or not len(self.speeds_mps):
            raise ValueError("steer speeds and shares must be lists of the same length")
        if (
            any(b <= a for a, b in zip(self.speeds_mps, self.speeds_mps[1:]))
            or min(self.shares) <= 0.0
        ):
            raise ValueError("steer speeds must rise, and their shares must be positive")

    def command(self, wheel_angle_rad: float, speed_mps: float):
        """The steer command in -1..1, positive to the RIGHT, for a wheel angle positive to the LEFT; returns (steer, limited)."""
        full = self.max_wheel_angle_rad * float(
            np.interp(abs(speed_mps), self.speeds_mps, self.shares)
        )
        wanted = -wheel_angle_rad / full
        steer = min(max(wanted, -1.0), 1.0)
        return steer, steer != wanted


@dataclass(frozen=True)
class PedalMap:
    """Throttle and brake that give an acceleration, as straight lines through the car's own curves.

    throttle_deadband: the throttle at which the car barely moves; throttle_gain_mps2, brake_gain_mps2: acceleration that a full unit of
    pedal adds beyond; coast_mps2: deceleration down to which the car merely rolls, so that throttle and brake do not take turns.
    """

    throttle_deadband: float
    throttle_gain_mps2: float
    brake_gain_mps2: float
    coast_mps2: float

    def __post_init__(self):
        check_between(0.0, 0.99, throttle_deadband=self.throttle_deadband)
        check_positive(
            throttle_gain_mps2=self.throttle_gain_mps2, brake_gain_mps2=self.brake_gain_mps2
        )
        check_non_negative(coast_mps2=self.coast_mps2)

    def pedals(self, acceleration_mps2: float):
        """(throttle, brake), each in 0..1 and never both, for a wanted acceleration."""
        if acceleration_mps2 > -self.coast_mps2:
            rise = (acceleration_mps2 + self.coast_mps2) / self.throttle_gain_mps2
            share = (
                min(1.0, (acceleration_mps2 + self.coast_mps2) / self.coast_mps2)
                if self.coast_mps2
                else 1.0
            )
            return min(1.0, self.throttle_deadband * share + rise), 0.0
        return 0.0, min(1.0, (-acceleration_mps2 - self.coast_mps2) / self.brake_gain_mps2)
