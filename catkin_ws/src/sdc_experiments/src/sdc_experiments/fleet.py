"""Many equal vehicles at once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any, Callable

import numpy as np

from sdc_common.machine_code import compiled
from sdc_sim.physics.compiled_vehicle import CALLEES, packed
from sdc_sim.physics.vehicle import INTERNAL_STEP_S, VehicleState
from sdc_sim.physics.vehicle_dynamics import MotionConstants
from sdc_sim.physics.vehicle_motion import integrate, step_count
from sdc_sim.physics.vehicle_parameters import VehicleParameters

FIELDS = tuple(VehicleState.__dataclass_fields__)
# With fewer vehicles, threads only wait for each other.
_LEAST_BLOCK = 64


def integrate_fleet(
    constants: Any,
    states: np.ndarray,
    goals: np.ndarray,
    duration_s: float,
    internal_step_s: float,
    first: int,
    last: int,
) -> None:
    """Advance some of many equal vehicles in place, in the forward gear.

    These are the columns from `first` to before `last` of the states (13, N) and of the goals
    (3, N): demanded throttle, brake and steer. See packed for the constants.
    """
    c = constants[0]
    for i in range(first, last):
        s = states[:, i]
        state = s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8], s[9], s[10], s[11], s[12]
        steps = step_count(state[3], duration_s, internal_step_s)
        goal = goals[0, i], goals[1, i], goals[2, i]
        after = integrate(c, state, goal, False, False, duration_s / steps, steps)
        for k in range(13):
            s[k] = after[k]


class VehicleFleet:
    """N equal vehicles on a flat road without wind, in the forward gear.

    Each moves as a Vehicle does, bit for bit. Numba makes a fleet about 60 times as fast.

    Attributes:
        state: (N,) array of each field of VehicleState, by name
    """

    def __init__(
        self, parameters: VehicleParameters, count: int, friction: float = 1.0, threads: int = 1
    ):
        self._values = np.zeros((len(FIELDS), count))
        self.state = dict(zip(FIELDS, self._values))
        self._constants = packed(MotionConstants.of(parameters, friction, 0.0))
        self._integrate = compiled(integrate_fleet, *CALLEES)
        threads = max(1, min(threads, count // _LEAST_BLOCK))
        bounds = np.linspace(0, count, threads + 1).astype(int).tolist()
        self._blocks = list(zip(bounds, bounds[1:]))
        self._map: Any = ThreadPoolExecutor(threads).map if threads > 1 else map

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
        arguments = self._constants, self._values, goals, duration_s, INTERNAL_STEP_S
        self.share(self._integrate, *arguments)

    def share(self, function: Callable[..., Any], *arguments: Any) -> None:
        """Call a function for all vehicles, on the threads of the fleet.

        After its arguments come the first vehicle and the one after the last.
        """
        for _ in self._map(lambda block: function(*arguments, *block), self._blocks):
            pass
