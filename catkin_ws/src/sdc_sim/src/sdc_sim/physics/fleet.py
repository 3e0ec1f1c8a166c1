"""Many equal vehicles at once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from sdc_sim.physics.vehicle import INTERNAL_STEP_S, VehicleState
from sdc_sim.physics.vehicle_motion import MotionConstants, compiled_integrate_fleet
from sdc_sim.physics.vehicle_parameters import VehicleParameters

FIELDS = tuple(VehicleState.__dataclass_fields__)
# With fewer vehicles, threads only wait for each other.
_LEAST_BLOCK = 64


class VehicleFleet:
    """N equal vehicles on a flat road without wind, in the forward gear.

    Each moves as a Vehicle does, bit for bit. Numba makes a fleet about 60 times as fast.

    Args:
        parameters: the vehicle
        count: number of vehicles, N
        friction: factor of the tyres' grip
        threads: number of threads that share the vehicles

    Attributes:
        state: (N,) array of each field of VehicleState, by name
    """

    def __init__(
        self, parameters: VehicleParameters, count: int, friction: float = 1.0, threads: int = 1
    ):
        self._values = np.zeros((len(FIELDS), count))
        self.state = dict(zip(FIELDS, self._values))
        self._constants = MotionConstants.of(parameters, friction, 0.0)
        self._integrate = compiled_integrate_fleet()
        threads = max(1, min(threads, count // _LEAST_BLOCK))
        bounds = np.linspace(0, count, threads + 1).astype(int).tolist()
        self._blocks = list(zip(bounds, bounds[1:]))
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None

    def reset(
        self, rows: np.ndarray, x_m: np.ndarray, y_m: np.ndarray, yaw_rad: np.ndarray
    ) -> None:
        """Place some vehicles at rest; `rows` are their indices or a mask."""
        self._values[:, rows] = 0.0
        self.state["x_m"][rows] = x_m
        self.state["y_m"][rows] = y_m
        self.state["yaw_rad"][rows] = yaw_rad

    def step(
        self, throttle: np.ndarray, brake: np.ndarray, steer: np.ndarray, duration_s: float
    ) -> None:
        """Drive all vehicles under one command each; see Command for the ranges."""
        goals = np.array([throttle, brake, steer])

        def drive(block: tuple[int, int]) -> None:
            self._integrate(
                self._constants, self._values, goals, duration_s, INTERNAL_STEP_S, *block
            )

        if self._pool is None:
            for block in self._blocks:
                drive(block)
        else:
            list(self._pool.map(drive, self._blocks))
