"""Errors of sensors: noise, a bias that walks, a scale error, all with a seed; and delay."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from typing import Any, NamedTuple, Sequence

import numpy as np

from sdc_sim.physics.vehicle import VehicleState

# Number of the random stream of what is drawn once for each drive.
_ONCE = 2**40


class ErrorSizes(NamedTuple):
    """Standard deviations of the errors of one quantity."""

    noise: float = 0.0  # of the white noise of each reading
    bias: float = 0.0  # of the bias at the start
    walk: float = 0.0  # of the change of the bias in one second
    scale: float = 0.0  # of the share by which readings are too large


class SensorErrors:
    """Errors of several quantities that one sensor measures.

    The numbers of a tick depend on the seed, the sensor and the number of the tick alone, so that
    no sensor changes the errors of another one. They are the same on every machine: neither the
    streams of Philox nor those of RandomState change between versions of NumPy.

    Args:
        seed: seed of the drive
        sensor: number of the sensor
        sizes: the errors of each quantity
        period_s: time between two readings
    """

    def __init__(self, seed: int, sensor: int, sizes: Sequence[ErrorSizes], period_s: float):
        self._seed, self._sensor = seed, sensor
        self._noise, self._start, walk, self._scale = np.array(sizes, float).reshape(-1, 4).T
        self._walk = walk * math.sqrt(period_s)
        self._varies = self._noise.any() or self._walk.any()
        self.reset()

    def reset(self) -> None:
        """Return to the start of the drive."""
        first, second = self.random(_ONCE).standard_normal(2 * len(self._start)).reshape(2, -1)
        self.bias = self._start * first  # present bias of each quantity
        self.factors = 1.0 + self._scale * second  # true values are measured times these

    def random(self, tick: int) -> np.random.RandomState:
        """Return the random numbers of a tick; those of `apply` are drawn from the same stream."""
        key = self._seed | self._sensor << 32
        return np.random.RandomState(np.random.Philox(counter=tick << 64, key=key))

    def apply(self, true: Sequence[float], tick: int) -> list[float]:
        """Return the measured values for the true ones in a tick, and let the bias walk."""
        measured = np.asarray(true) * self.factors
        if not self._varies:
            return (measured + self.bias).tolist()
        first, second = self.random(tick).standard_normal(2 * len(true)).reshape(2, -1)
        self.bias = self.bias + self._walk * second
        return (measured + self.bias + self._noise * first).tolist()


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
    """

    def __init__(
        self, seed: int, position_m: float = 0.0, heading_rad: float = 0.0, speed_mps: float = 0.0
    ):
        self.set_deviations(position_m, heading_rad, speed_mps)
        self._seed = seed
        self._random = np.random.RandomState(seed)

    def set_deviations(self, position_m: float, heading_rad: float, speed_mps: float) -> None:
        """Set the standard deviations from now on; the random numbers continue."""
        sigmas = position_m, position_m, heading_rad, speed_mps
        self._sigmas = dict(zip(("x_m", "y_m", "yaw_rad", "speed_mps"), sigmas))

    def apply(self, true: VehicleState) -> VehicleState:
        """Return the measured state for the true one."""
        if not any(self._sigmas.values()):
            return true
        draws = self._random.standard_normal(4).tolist()
        noise = zip(self._sigmas.items(), draws)
        errors = {name: sigma * draw for (name, sigma), draw in noise if sigma}
        return replace(true, **{name: getattr(true, name) + errors[name] for name in errors})

    def reset(self) -> None:
        """Begin the random numbers again."""
        self._random = np.random.RandomState(self._seed)


class DelayLine:
    """Returns each item a fixed number of ticks after it was put in.

    Args:
        delay_s: delay; it is rounded to whole ticks, halves upwards
        tick_s: duration of a tick
    """

    def __init__(self, delay_s: float, tick_s: float):
        # 1e-9 compensates rounding: 0.15 / 0.1 is 1.4999..., but 1.5 ticks are rounded to 2.
        self.ticks = int(math.floor(delay_s / tick_s + 0.5 + 1e-9))
        self._line: deque[Any] = deque()

    def put(self, item: Any) -> Any:
        """Put in the item of this tick; return that of `ticks` ticks ago, None until it fills."""
        self._line.append(item)
        return self._line.popleft() if len(self._line) > self.ticks else None

    def clear(self) -> None:
        """Remove all items."""
        self._line.clear()
