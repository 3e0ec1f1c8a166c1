"""Convert wheel angle to steer and acceleration to pedals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Sequence

from sdc_common.piecewise_linear import Segments, evaluate, linear_segments
from sdc_common.validation import check_between, check_non_negative, check_positive, is_number


@dataclass(frozen=True)
class SteeringMap:
    """The front wheel angle that a steer command causes."""

    # Wheel angle of the bicycle model at full steer and standstill [rad]
    max_wheel_angle_rad: float
    speeds_mps: Sequence[float]  # speeds at which the shares are given, rising [m/s]
    # Share of the maximum angle at these speeds; linear in between, constant beyond
    shares: Sequence[float]

    def __post_init__(self):
        check_between(1e-3, 0.499 * math.pi, max_wheel_angle_rad=self.max_wheel_angle_rad)
        for name in ("speeds_mps", "shares"):
            values = getattr(self, name)
            if not (isinstance(values, (list, tuple)) and all(map(is_number, values))):
                raise ValueError(f"steering: '{name}' must be a list of numbers, got {values!r}")
        if len(self.speeds_mps) != len(self.shares) or not len(self.speeds_mps):
            raise ValueError(
                "steering: 'speeds_mps' and 'shares' must have the same length, at least 1; got "
                f"{len(self.speeds_mps)} and {len(self.shares)}"
            )
        if any(after <= before for before, after in zip(self.speeds_mps, self.speeds_mps[1:])):
            raise ValueError(f"steering: 'speeds_mps' must rise, got {list(self.speeds_mps)}")
        if min(self.shares) <= 0.0:
            raise ValueError(f"steering: 'shares' must be positive, got {list(self.shares)}")

    @cached_property
    def _share_of_speed(self) -> Segments:
        return linear_segments(self.speeds_mps, self.shares)

    def command(self, wheel_angle_rad: float, speed_mps: float) -> tuple[float, bool]:
        """Return the steer command for a wheel angle, and whether it is limited.

        Args:
            wheel_angle_rad: front wheel angle, positive LEFT [rad]
            speed_mps: speed of the car [m/s]

        Returns:
            steer in -1..1, positive RIGHT, and True if the angle is out of the car's reach
        """
        share = evaluate(abs(speed_mps), self._share_of_speed)
        wanted = -wheel_angle_rad / (self.max_wheel_angle_rad * share)
        steer = min(max(wanted, -1.0), 1.0)
        return steer, steer != wanted


@dataclass(frozen=True)
class PedalMap:
    """The acceleration that the pedals cause, as straight lines through the car's own curves."""

    throttle_deadband: float  # throttle below which the car only creeps, 0..1
    throttle_gain_mps2: float  # acceleration per unit of throttle beyond the deadband [m/s^2]
    brake_gain_mps2: float  # deceleration per unit of brake [m/s^2]
    # Deceleration without any pedal; down to it, the car coasts instead of alternating between
    # throttle and brake [m/s^2]
    coast_mps2: float

    def __post_init__(self):
        check_between(0.0, 0.99, throttle_deadband=self.throttle_deadband)
        check_positive(
            throttle_gain_mps2=self.throttle_gain_mps2, brake_gain_mps2=self.brake_gain_mps2
        )
        check_non_negative(coast_mps2=self.coast_mps2)

    def pedals(self, acceleration_mps2: float) -> tuple[float, float]:
        """Return (throttle, brake) for an acceleration; each in 0..1, at most one of them above 0.

        Args:
            acceleration_mps2: wanted acceleration, negative to brake [m/s^2]
        """
        above_coasting = acceleration_mps2 + self.coast_mps2
        if above_coasting > 0.0:
            # Between coasting and constant speed, the deadband fades in, so that the throttle never
            # jumps.
            share = min(1.0, above_coasting / self.coast_mps2) if self.coast_mps2 else 1.0
            throttle = self.throttle_deadband * share + above_coasting / self.throttle_gain_mps2
            return min(1.0, throttle), 0.0
        return 0.0, min(1.0, (-acceleration_mps2 - self.coast_mps2) / self.brake_gain_mps2)
