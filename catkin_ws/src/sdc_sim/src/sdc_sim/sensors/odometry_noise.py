"""Noise of the odometry, with a seed."""

from __future__ import annotations

import numpy as np

from sdc_common.validation import check_non_negative


class OdometryNoise:
    """Adds independent Gaussian noise to position, heading and speed.

    The same seed gives the same noise on every machine: the streams of NumPy's RandomState do not
    change between versions. Each call draws all four numbers, so that one kind of noise does not
    depend on the others. Without noise the input is returned unchanged.

    Args:
        seed: seed of the random numbers
        position_m: standard deviation of x and of y
        heading_rad: standard deviation of the heading
        speed_mps: standard deviation of the speed

    Attributes:
        is_on: whether there is any noise

    Raises:
        ValueError: a standard deviation is negative or not a number
    """

    def __init__(
        self, seed: int, position_m: float = 0.0, heading_rad: float = 0.0, speed_mps: float = 0.0
    ):
        self.set_deviations(position_m, heading_rad, speed_mps)
        self._seed = seed
        self._random = np.random.RandomState(seed)

    def set_deviations(
        self, position_m: float = 0.0, heading_rad: float = 0.0, speed_mps: float = 0.0
    ) -> None:
        """Set the standard deviations from now on; the random numbers continue.

        Raises:
            ValueError: a standard deviation is negative or not a number; nothing changes
        """
        for name, sigma in (
            ("position_m", position_m),
            ("heading_rad", heading_rad),
            ("speed_mps", speed_mps),
        ):
            check_non_negative(**{f"odometry_noise.{name}": sigma})
        self._sigmas = (position_m, position_m, heading_rad, speed_mps)
        self.is_on = any(self._sigmas)

    def apply(
        self, x_m: float, y_m: float, yaw_rad: float, speed_mps: float
    ) -> tuple[float, float, float, float]:
        """Return measured (x, y, yaw, speed) for these true values."""
        true = (x_m, y_m, yaw_rad, speed_mps)
        if not self.is_on:
            return true
        draws = self._random.standard_normal(4).tolist()
        x, y, yaw, speed = [
            value + sigma * draw if sigma else value
            for value, sigma, draw in zip(true, self._sigmas, draws)
        ]
        return x, y, yaw, speed

    def reset(self) -> None:
        """Begin the random numbers again."""
        self._random = np.random.RandomState(self._seed)
