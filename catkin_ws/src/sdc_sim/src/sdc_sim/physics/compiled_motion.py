"""The motion of vehicles in machine code, where Numba is installed; see machine_code."""

from __future__ import annotations

from typing import Any, Callable

import numpy as np

from sdc_common import piecewise_linear
from sdc_common.machine_code import compiled, numba_module
from sdc_sim.physics import vehicle_dynamics, vehicle_motion

_CALLEES = (
    piecewise_linear.evaluate,
    vehicle_dynamics.tyre_forces,
    vehicle_dynamics.derivatives,
    vehicle_motion.approach,
    vehicle_motion.drive_force,
    vehicle_motion.resistance,
    vehicle_motion.heun_step,
    vehicle_motion.step_count,
)


def integrate() -> Callable[..., Any]:
    """Return vehicle_motion.integrate for `packed` constants, compiled if Numba is installed."""
    if numba_module() is None:
        return vehicle_motion.integrate
    return compiled(_integrate, *_CALLEES, vehicle_motion.integrate)


def packed(constants: vehicle_motion.MotionConstants) -> Any:
    """Return the constants in an array of one element if Numba is installed.

    A compiled function takes longer to read 70 numbers from tuples than for the rest of a tick.
    """
    if numba_module() is None:
        return constants
    values = [np.array(value) for value in constants]
    fields = [(n, value.dtype, value.shape) for n, value in zip(constants._fields, values)]
    return np.array([tuple(values)], dtype=fields)


def _integrate(constants: np.ndarray, *arguments: Any) -> vehicle_motion.Motion:
    return vehicle_motion.integrate(constants[0], *arguments)


def integrate_fleet() -> Callable[..., Any]:
    """Return vehicle_motion.integrate_fleet, compiled if Numba is installed."""
    return compiled(vehicle_motion.integrate_fleet, *_CALLEES, vehicle_motion.integrate)
