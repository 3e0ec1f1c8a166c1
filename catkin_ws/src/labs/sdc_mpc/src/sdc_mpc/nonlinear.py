"""The steering method mpc with the nonlinear model and CasADi's IPOPT, to compare with.

It estimates and refers to the same horizon, and has the same cost and limits. Only the model is not
linear: sines of the heading error, the path's curvature at an offset, and the slip angles of both
axles. It needs no real time.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sdc_common.configuration import how_to_install
from sdc_mpc.steering import Horizon, MpcSteering
from sdc_package.steering.lqr import steady_state

try:
    import casadi
except ImportError as error:
    raise ValueError(f"casadi is not installed; {how_to_install('mpc')}") from error

_STATES, _INPUTS = 5, 2
# Below this speed the slip angles of the model would divide by zero.
_LEAST_MPS = 2.0
_SUBSTEPS = 2


class NonlinearMpc(MpcSteering):
    """Nonlinear MPC of wheel angle and acceleration."""

    def __post_init__(self):
        super().__post_init__()
        n = self.steps
        states, inputs = casadi.SX.sym("z", _STATES, n), casadi.SX.sym("u", _INPUTS, n)
        parameters = {
            name: casadi.SX.sym(name, *size)
            for name, size in {
                "start": (_STATES, 1),
                "last": (_INPUTS, 1),
                "offsets": (_INPUTS, 1),
                "curvatures": (1, n),
                "references": (2, n),  # heading error and speed
                "weights": (_INPUTS, n),  # of changes
            }.items()
        }
        p = parameters
        defects, changes, cost = [], [], 0.0
        state, last = p["start"], p["last"]
        for k in range(n):
            defects.append(
                states[:, k]
                - self._after_tick(state, inputs[:, k] + p["offsets"], p["curvatures"][k])
            )
            changes.append(inputs[:, k] - last)
            cost += casadi.dot(p["weights"][:, k], changes[-1] ** 2)
            state, last = states[:, k], inputs[:, k]
            e, theta, speed = state[0], state[1] - p["references"][0, k], state[4]
            errors = self.cross_track_weight * e**2 + self.heading_weight * theta**2
            cost += errors * (5.0 if k == n - 1 else 1.0)
            cost += self.speed_weight * (speed - p["references"][1, k]) ** 2
        self._names = list(parameters)
        self._solver = casadi.nlpsol(
            "mpc",
            "ipopt",
            {
                "x": casadi.vertcat(casadi.vec(states), casadi.vec(inputs)),
                "p": casadi.vertcat(*map(casadi.vec, parameters.values())),
                "f": cost,
                "g": casadi.vertcat(*defects, *changes),
            },
            {
                "print_time": False,
                "ipopt": {"print_level": 0, "sb": "yes", "max_iter": 50, "tol": 1e-5},
            },
        )
        self._guess = np.zeros((_STATES + _INPUTS) * n)

    def _after_tick(self, state: Any, inputs: Any, curvature: Any) -> Any:
        """Return the state after a tick, by Runge-Kutta's method."""
        axles, h = self.axles, self.tick_s / _SUBSTEPS
        front = axles.rear_m / axles.wheelbase_m / axles.front_compliance
        rear = axles.front_m / axles.wheelbase_m / axles.rear_compliance
        tangent, acceleration = inputs[0], inputs[1]

        def rates(z: Any) -> Any:
            e, theta, v, r, u = (z[i] for i in range(_STATES))
            speed = casadi.fmax(u, _LEAST_MPS)
            wheel = casadi.atan(tangent)
            force_front = front * (wheel - casadi.atan((v + axles.front_m * r) / speed))
            force_rear = -rear * casadi.atan((v - axles.rear_m * r) / speed)
            lateral = force_front * casadi.cos(wheel) + force_rear - speed * r
            moment = axles.front_m * force_front * casadi.cos(wheel) - axles.rear_m * force_rear
            along = (u * casadi.cos(theta) - v * casadi.sin(theta)) / (1.0 - curvature * e)
            return casadi.vertcat(
                u * casadi.sin(theta) + v * casadi.cos(theta),
                r - curvature * along,
                lateral,
                moment / self.gyration_m**2,
                acceleration,
            )

        for _ in range(_SUBSTEPS):
            k1 = rates(state)
            k2 = rates(state + 0.5 * h * k1)
            k3 = rates(state + 0.5 * h * k2)
            k4 = rates(state + h * k3)
            state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        return state

    def plan(self, horizon: Horizon) -> tuple[float, float]:
        """See MpcSteering.plan."""
        n, t = self.steps, self.tick_s
        self._linearize(horizon.speeds_mps, horizon.curvatures)  # the weights
        bends = zip(horizon.curvatures.tolist(), horizon.speeds_mps[1:].tolist())
        headings = [steady_state(*bend, self.axles)[1] for bend in bends]
        values = {
            "start": horizon.start,
            "last": self.estimator.last_sent,
            "offsets": (horizon.wheel_offset_rad, horizon.pull_mps2),
            "curvatures": horizon.curvatures,
            "references": np.array([headings, horizon.references_mps]),
            "weights": self._change_weights.T,
        }
        most = math.tan(self.max_wheel_angle_rad)
        turn = 2.0 * self.max_wheel_angle_rad / self.steer_travel_s * t
        free, fixed = np.full(_STATES * n, np.inf), np.zeros(_STATES * n)
        limits = np.tile([most, self.max_acceleration_mps2], n)
        changes = np.tile([turn, self.emergency_jerk_mps3 * t], n)
        solution = self._solver(
            x0=self._guess,
            p=np.concatenate([np.ravel(values[name], order="F") for name in self._names]),
            lbx=np.concatenate([-free, np.tile([-most, -self.braking_mps2], n)]),
            ubx=np.concatenate([free, limits]),
            lbg=np.concatenate([fixed, -changes]),
            ubg=np.concatenate([fixed, np.tile([turn, self.jerk_mps3 * t], n)]),
        )
        self._guess = np.array(solution["x"]).ravel()
        wheel, acceleration = self._guess[_STATES * n : _STATES * n + _INPUTS]
        return float(wheel), float(acceleration)
