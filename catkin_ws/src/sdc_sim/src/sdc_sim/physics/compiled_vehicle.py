"""A vehicle in machine code, where Numba is installed."""

from __future__ import annotations

from typing import Any

import numpy as np

from sdc_common.machine_code import compiled, numba_module
from sdc_common.piecewise_linear import evaluate
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.physics.vehicle_dynamics import MotionConstants, derivatives, tyre_forces
from sdc_sim.physics.vehicle_motion import (
    Motion,
    approach,
    drive_force,
    heun_step,
    integrate,
    resistance,
    step_count,
)

# The functions that a compiled one calls for a vehicle.
CALLEES = (
    evaluate,
    tyre_forces,
    derivatives,
    approach,
    drive_force,
    resistance,
    heun_step,
    step_count,
    integrate,
)


class CompiledVehicle(Vehicle):
    """A Vehicle in machine code, for the same numbers; pays after an hour of simulated drives."""

    def set_conditions(self, friction: float, side_wind_mps: float) -> None:
        """Set the factor of the tyres' grip and the side wind; see Vehicle.set_conditions."""
        super().set_conditions(friction, side_wind_mps)
        self._constants = packed(self._constants)
        self._integrate = compiled(_integrate, *CALLEES)


def packed(constants: MotionConstants) -> Any:
    """Return the constants as the element of an array if Numba is installed, else of a list.

    A compiled function takes longer to read 70 numbers from tuples than for the rest of a tick.
    """
    if numba_module() is None:
        return [constants]
    values = {name: np.array(value) for name, value in vars(constants).items()}
    fields = [(name, value.dtype, value.shape) for name, value in values.items()]
    return np.array([tuple(values.values())], dtype=fields)


def _integrate(constants: Any, *arguments: Any) -> Motion:
    return integrate(constants[0], *arguments)
