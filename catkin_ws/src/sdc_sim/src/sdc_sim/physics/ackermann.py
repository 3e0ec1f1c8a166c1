"""Control of the vehicle by speed and wheel angle, the second control mode of the CARLA bridge.

The fields have the meaning of ackermann_msgs/AckermannDrive: the angle is that of a virtual wheel
in the middle of the front axle, positive to the left; a negative speed drives in reverse; a rate,
acceleration or jerk of zero means as fast as possible.
"""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass, replace
from types import SimpleNamespace

from sdc_common.driving import Command
from sdc_sim.physics.vehicle_dynamics import AIR_DENSITY_KGPM3, GRAVITY_MPS2
from sdc_sim.physics.vehicle_parameters import VehicleParameters


@dataclass(frozen=True)
class AckermannTarget:
    """A demand of speed and wheel angle."""

    steering_angle_rad: float = 0.0
    steering_rate_radps: float = 0.0
    speed_mps: float = 0.0
    acceleration_mps2: float = 0.0
    jerk_mps3: float = 0.0


# The section `ackermann` of config/sim.yaml, which describes them, as attributes.
AckermannGains = SimpleNamespace


class AckermannControl:
    """A PI speed loop with anti-windup, on the drive, brake and steering curves of the vehicle."""

    def __init__(self, parameters: VehicleParameters, gains: AckermannGains):
        self.parameters = parameters
        self.gains = gains
        self.reset()

    def reset(self) -> None:
        """Forget the past, as after another control mode."""
        self._integral_mps2 = 0.0
        self._acceleration_mps2 = 0.0
        self._angle_rad: float | None = None

    def limited(self, target: AckermannTarget) -> tuple[AckermannTarget, bool]:
        """Return the target within the limits of the vehicle, and whether it was outside them.

        Raises:
            ValueError: a value is NaN or infinite
        """
        for name, value in vars(target).items():
            if not math.isfinite(value):
                raise ValueError(f"command refused: {name} is {value}")
        max_speed_mps = self.gains.max_speed_mps
        max_angle_rad = self.parameters.full_wheel_angle_rad(0.0)
        within = AckermannTarget(
            min(max(target.steering_angle_rad, -max_angle_rad), max_angle_rad),
            max(target.steering_rate_radps, 0.0),
            min(max(target.speed_mps, -max_speed_mps), max_speed_mps),
            max(target.acceleration_mps2, 0.0),
            max(target.jerk_mps3, 0.0),
        )
        return within, within != target

    def command(
        self, target: AckermannTarget, speed_mps: float, wheel_angle_rad: float, step_s: float
    ) -> Command:
        """Return pedals and steering for the next step.

        Args:
            target: the demand, within the limits
            speed_mps: speed of the vehicle, negative in reverse
            wheel_angle_rad: present wheel angle, positive left
            step_s: duration of the step
        """
        gains = self.gains
        steer = self._steer(target, speed_mps, wheel_angle_rad, step_s)
        reverse = target.speed_mps < 0.0
        changes_direction = (
            speed_mps * target.speed_mps < 0.0 and abs(speed_mps) > gains.standstill_mps
        )
        if changes_direction:
            target = replace(target, speed_mps=0.0)
            reverse = speed_mps < 0.0
        elif target.speed_mps == 0.0:
            reverse = speed_mps < 0.0
            if abs(speed_mps) < gains.standstill_mps:
                self._integral_mps2 = self._acceleration_mps2 = 0.0
                return Command(steer=steer, brake=gains.hold_brake)
        forward_mps = -speed_mps if reverse else speed_mps
        throttle, brake = self._pedals(
            self._acceleration(target, abs(target.speed_mps) - forward_mps, step_s), forward_mps
        )
        return Command(throttle=throttle, steer=steer, brake=brake, reverse=reverse)

    def _steer(
        self, target: AckermannTarget, speed_mps: float, wheel_angle_rad: float, step_s: float
    ) -> float:
        angle_rad = wheel_angle_rad if self._angle_rad is None else self._angle_rad
        change = target.steering_angle_rad - angle_rad
        if target.steering_rate_radps > 0.0:
            most = target.steering_rate_radps * step_s
            change = min(max(change, -most), most)
        self._angle_rad = angle_rad + change
        full = self.parameters.full_wheel_angle_rad(speed_mps)
        return min(max(-self._angle_rad / full, -1.0), 1.0)

    def _acceleration(self, target: AckermannTarget, error_mps: float, step_s: float) -> float:
        gains = self.gains
        asked = target.acceleration_mps2 or math.inf
        highest, lowest = min(asked, gains.acceleration_mps2), -min(asked, gains.braking_mps2)
        if target.jerk_mps3 > 0.0:
            change = target.jerk_mps3 * step_s
            highest = max(min(highest, self._acceleration_mps2 + change), lowest)
            lowest = min(max(lowest, self._acceleration_mps2 - change), highest)
        wanted = gains.kp_per_s * error_mps + self._integral_mps2
        acceleration = min(max(wanted, lowest), highest)
        if acceleration == wanted:
            self._integral_mps2 += gains.ki_per_s2 * error_mps * step_s
        self._acceleration_mps2 = acceleration
        return acceleration

    def _pedals(self, acceleration_mps2: float, forward_mps: float) -> tuple[float, float]:
        p = self.parameters
        drag_n = 0.5 * AIR_DENSITY_KGPM3 * p.drag_area_m2 * forward_mps * abs(forward_mps)
        force_n = p.mass_kg * (acceleration_mps2 + p.rolling_resistance * GRAVITY_MPS2) + drag_n
        if force_n <= 0.0:
            return 0.0, min(1.0, -force_n / p.brake_force_n)
        forces, throttles = p.drive_forces_n, p.throttle_points
        index = bisect.bisect_left(forces, force_n)
        if index >= len(forces):
            return 1.0, 0.0
        share = (force_n - forces[index - 1]) / (forces[index] - forces[index - 1])
        throttle = throttles[index - 1] + share * (throttles[index] - throttles[index - 1])
        if p.creep_force_n > 0.0:
            creep = (force_n + p.creep_damping_n_per_mps * abs(forward_mps)) / p.creep_force_n
            throttle = min(throttle, creep)  # the drive force is the larger of both
        return throttle, 0.0
