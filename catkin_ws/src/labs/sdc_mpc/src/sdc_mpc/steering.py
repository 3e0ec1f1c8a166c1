"""Model predictive control of steering and acceleration together.

In each tick the controller predicts the car over the next second, finds the wheel angles and
accelerations with the least cost within the limits of the car, and sends the first of them. The
model is linear about the planned speeds and the curvature of the path (linear time-varying), so
that a quadratic program with a sparse matrix remains:

    minimize sum of  cross_track_weight e^2 + heading_weight (theta - theta_ref)^2
                     + speed_weight (u - u_ref)^2 + weights of the changes of w and a
    subject to       z[k+1] = A[k] z[k] + B[k] (w[k], a[k]) + c[k],   z = (e, theta, v, r, u)
                     limits of w and a, and of their changes from tick to tick

with the cross-track error e, the heading error theta, the lateral speed v, the yaw rate r, the
speed u, the wheel angle w and the acceleration a. In a bend the car drives with the slip angle
theta_ref. A Kalman filter estimates the motion, and how late a command acts; the prediction starts
at that time.

Reference: P. Falcone et al., "Predictive Active Steering Control for Autonomous Vehicle Systems",
IEEE Transactions on Control Systems Technology 15(3), 2007 (the linear time-varying MPC); B.
Stellato et al., "OSQP: an operator splitting solver for quadratic programs", Mathematical
Programming Computation 12, 2020.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import sparse

from sdc_common.configuration import how_to_install
from sdc_common.geometry.angles import wrap_angle
from sdc_common.validation import check_between, check_non_negative, check_positive
from sdc_mpc.motion_estimator import MotionEstimator, TickModel
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import MAX_SLIP_SINE, Axles
from sdc_package.steering.lqr import steady_state
from sdc_package.steering.method import Steering

_E, _THETA, _V, _R, _U = range(5)
_STATES = 5
# Constraints of a tick: the model, two changes and two limits.
_ROWS = _STATES + 4
# Factor of the weights of the last errors of the horizon: they count for all that follow.
_TERMINAL = 5.0
# The matrices of a linearization are used again while no speed differs by more from its own [m/s].
_SAME_SPEED_MPS = 0.02
# The same for the curvatures [1/m].
_SAME_CURVATURE = 2e-4
# A car that is faster than planned by more brakes with the jerk of an emergency [m/s].
_LATE_MPS = 3.0
# The path is extended behind its end by this distance, farther than a horizon of 1 s reaches [m].
_BEYOND_M = 100.0
# Parameters that can be zero; all others must be positive.
_CAN_BE_ZERO = (
    "heading_weight",
    "wheel_change_weight",
    "lateral_change_weight",
    "slow_mps",
    "delay_s",
    "longest_delay_s",
)


class Horizon(NamedTuple):
    """What the controller plans for."""

    start: np.ndarray  # (5,) e, theta, v, r, u when the next command acts
    wheel_offset_rad: float  # added to each wheel angle
    pull_mps2: float  # added to each acceleration
    speeds_mps: np.ndarray  # (n + 1,) speeds of the linearization, from the start on
    references_mps: np.ndarray  # (n,) planned speeds, after each tick
    turns_rad: np.ndarray  # (n,) change of the path's heading in each tick
    curvatures: np.ndarray  # (n,) curvature of the path in each tick [1/m]


class QuadraticProgram:
    """minimize 0.5 x' p x + q' x with lower <= a x <= upper, solved by OSQP.

    The solver keeps its factorization while the matrices stay, and starts at its last solution.

    Args:
        p: (n, n) upper triangle of the cost; later ones have no other nonzero entries
        a: (m, n) matrix of the constraints, in the same way

    Raises:
        ValueError: OSQP is not installed
    """

    def __init__(self, p: np.ndarray, a: np.ndarray):
        try:
            import osqp
        except ImportError as error:
            raise ValueError(f"osqp is not installed; {how_to_install('mpc')}") from error
        matrices = [sparse.csc_matrix(dense) for dense in (p, a)]
        # Rows and columns of the nonzero entries of p and of a.
        self._places = [
            (matrix.indices, np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr)))
            for matrix in matrices
        ]
        self._solver = osqp.OSQP()
        # The interval is in iterations: one in time would give another result in each run.
        self._solver.setup(
            matrices[0], np.zeros(len(p)), matrices[1], np.zeros(len(a)), np.zeros(len(a)),
            verbose=False, rho=1.0, adaptive_rho_interval=50, check_termination=10,
            eps_abs=1e-4, eps_rel=1e-4, max_iter=400,
        )  # fmt: skip

    def solve(
        self,
        q: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
        p: np.ndarray | None = None,
        a: np.ndarray | None = None,
    ) -> np.ndarray:
        """Return x (n,); without p and a, those of the last problem remain."""
        matrices = {}
        if p is not None and a is not None:
            matrices = {"Px": p[self._places[0]], "Ax": a[self._places[1]]}
        self._solver.update(q=q, l=lower, u=upper, **matrices)
        return self._solver.solve(raise_error=False).x


@dataclass(eq=False)
class MpcSteering(Steering):
    """Linear time-varying MPC of wheel angle and acceleration."""

    axles: Axles  # geometry and tyres of the car
    steps: int  # ticks of the horizon
    cross_track_weight: float  # [1/m^2]
    heading_weight: float  # [1/rad^2]
    speed_weight: float  # [s^2/m^2]
    wheel_change_weight: float  # of the change of the wheel angle in a tick [1/rad^2]
    # Of the change of the lateral acceleration that the wheel angle causes [s^4/m^2]
    lateral_change_weight: float
    acceleration_change_weight: float  # of the change of the acceleration in a tick [s^4/m^2]
    max_acceleration_mps2: float  # [m/s^2]
    braking_mps2: float  # maximum deceleration [m/s^2]
    jerk_mps3: float  # maximum change of the acceleration [m/s^3]
    emergency_jerk_mps3: float  # while the car is more than 3 m/s too fast [m/s^3]
    max_wheel_angle_rad: float  # [rad]
    steer_travel_s: float  # time of the steering from end to end [s]
    slow_mps: float  # below it, or before a stop, the speed control drives [m/s]
    position_noise_m: float  # see MotionFilter
    heading_noise_rad: float
    speed_noise_mps: float
    delay_s: float  # see MotionEstimator
    longest_delay_s: float
    gyration_m: float  # radius of gyration about the vertical axis, sqrt(yaw inertia / mass) [m]
    tick_s: float  # time for which a command holds [s]

    def __post_init__(self):
        numbers = dict(vars(self))
        axles = numbers.pop("axles")
        check_positive(compliance=min(axles.front_compliance, axles.rear_compliance))
        check_between(2, 100, steps=numbers.pop("steps"))
        check_between(1e-3, 0.499 * math.pi, max_wheel_angle_rad=self.max_wheel_angle_rad)
        check_non_negative(**{name: numbers.pop(name) for name in _CAN_BE_ZERO})
        check_positive(**numbers)
        model = TickModel(axles, self.gyration_m, self.tick_s)
        noises = self.position_noise_m, self.heading_noise_rad, self.speed_noise_mps
        check_between(0.0, 1e3, position_noise_m=noises[0])
        check_between(0.0, 1e3, heading_noise_rad=noises[1], speed_noise_mps=noises[2])
        delays_s = self.delay_s, self.longest_delay_s
        self.estimator = MotionEstimator(model, self.tick_s, noises, *delays_s)
        self._model = model
        # Each entry that can differ from zero does so in a bend.
        bend = np.full(self.steps + 1, 10.0), np.full(self.steps, 0.1)
        self._program = QuadraticProgram(**self._linearize(*bend))
        self._linearized = bend

    def wheel_angle(
        self,
        path: ReferencePath,
        x_m: float,
        y_m: float,
        yaw_rad: float,
        speed_mps: float,
        yaw_rate_radps: float = 0.0,
    ) -> float:
        """See Steering.wheel_angle; `acceleration_mps2` is the acceleration that goes with it."""
        curvature = yaw_rate_radps / max(speed_mps, self.slow_mps)
        wheel, slip = steady_state(curvature, speed_mps, self.axles)
        motion = -slip * speed_mps, yaw_rate_radps
        self.estimator.update((x_m, y_m, yaw_rad), speed_mps, math.tan(wheel), motion)
        horizon = self._horizon(path, self.estimator.when_command_acts())
        tangent, acceleration = self.plan(horizon)
        self.estimator.sent(tangent, acceleration)
        slowest_mps = min(horizon.start[_U], horizon.references_mps.min())
        self.acceleration_mps2 = acceleration if slowest_mps > self.slow_mps else None
        # A rolling car turns with the tangent of its wheel angle, which the linear model knows.
        return math.atan(tangent)

    def _horizon(self, path: ReferencePath, state: np.ndarray) -> Horizon:
        """Return what lies ahead of a state on a path."""
        line, t = path.line, self.tick_s
        gain = self.max_acceleration_mps2 * t
        x, y, yaw, lateral, rate, wheel_offset, speed, pull = state.tolist()
        place = line.nearest(x, y)
        s, headings = np.array(line.s), np.array(line.headings)
        planned = np.array([row[2] for row in path.rows])
        # Behind its end the path goes on in its last bend, unless the car stops there.
        end = line.curvature_at(s[-1]) if planned[-1] > 0.0 else 0.0
        s, planned = np.append(s, s[-1] + _BEYOND_M), np.append(planned, planned[-1])
        headings = np.append(headings, headings[-1] + _BEYOND_M * end)
        speeds = np.full(self.steps + 1, speed)
        for _ in range(2):  # the speeds depend on the places, and these on the speeds
            steps_m = speeds[:-1] * t
            places = place.s_m + np.concatenate([[0.0], np.cumsum(steps_m)])
            references = np.sqrt(np.interp(places[1:], s, planned**2))
            for k, reference in enumerate(references.tolist()):
                change = min(max(reference - speeds[k], -self.braking_mps2 * t), gain)
                speeds[k + 1] = speeds[k] + change
        # The speed is that along the body, and in a bend the car moves a little to its side.
        curvatures = np.diff(np.interp(places, s, headings)) / np.maximum(steps_m, 1e-3)
        slips = np.minimum(np.abs(self.axles.rear_m * curvatures), MAX_SLIP_SINE)
        places[1:] = place.s_m + np.cumsum(steps_m / np.sqrt(1.0 - slips**2))
        turns = np.diff(np.interp(places, s, headings))
        heading_error = wrap_angle(yaw - place.heading_rad)
        start = np.array([place.cross_track_m, heading_error, lateral, rate, speed])
        curvatures = turns / np.maximum(np.diff(places), 1e-3)
        return Horizon(start, wheel_offset, pull, speeds, references, turns, curvatures)

    def plan(self, horizon: Horizon) -> tuple[float, float]:
        """Return the wheel angle [rad] and the acceleration [m/s^2] of the next tick."""
        n, t, speeds = self.steps, self.tick_s, horizon.speeds_mps
        matrices: dict[str, np.ndarray] = {}
        near = (speeds, _SAME_SPEED_MPS), (horizon.curvatures, _SAME_CURVATURE)
        if any(np.abs(a - b).max() > most for (a, most), b in zip(near, self._linearized)):
            self._linearized = speeds, horizon.curvatures
            matrices = self._linearize(speeds, horizon.curvatures)
        # The part of the model that does not depend on what is planned.
        c = np.zeros((n, _STATES))
        c[:, :_U] = self._b[:, :_U, 0] * horizon.wheel_offset_rad
        c[:, _E] -= 0.5 * speeds[:-1] * t * horizon.turns_rad
        c[:, _THETA] -= horizon.turns_rad + self._a[:, _THETA, _U] * speeds[:-1]
        c[:, _U] = horizon.pull_mps2 * t
        c[0] += self._a[0] @ horizon.start
        # The cost of the difference to the references, and to the last command.
        last = np.array(self.estimator.last_sent)
        references = np.zeros((n, _STATES))
        bends = zip(horizon.curvatures.tolist(), speeds[1:].tolist())
        references[:, _THETA] = [steady_state(*bend, self.axles)[1] for bend in bends]
        references[:, _U] = horizon.references_mps
        q = np.zeros((n, _STATES + 2))
        q[:, :_STATES] = -self._weights * references
        q[0, _STATES:] = -self._change_weights[0] * last
        late = horizon.references_mps[0] < horizon.start[_U] - _LATE_MPS
        jerk = self.emergency_jerk_mps3 if late else self.jerk_mps3
        most = math.tan(self.max_wheel_angle_rad)
        turn = 2.0 * self.max_wheel_angle_rad / self.steer_travel_s
        change = np.tile((turn, self.jerk_mps3), (n, 1)) * t
        least_change = -np.tile((turn, jerk), (n, 1)) * t
        change[0] += last
        least_change[0] += last
        upper = np.hstack([c, change, np.tile((most, self.max_acceleration_mps2), (n, 1))])
        lower = np.hstack([c, least_change, np.tile((-most, -self.braking_mps2), (n, 1))])
        x = self._program.solve(q.ravel(), lower.ravel(), upper.ravel(), **matrices)
        wheel, acceleration = x[_STATES : _STATES + 2]
        acceleration = min(max(acceleration, -self.braking_mps2), self.max_acceleration_mps2)
        return float(min(max(wheel, -most), most)), float(acceleration)

    def _linearize(self, speeds: np.ndarray, curvatures: np.ndarray) -> dict[str, np.ndarray]:
        """Return the matrices of the program about these speeds and curvatures.

        The unknowns of a tick are the seven numbers (z, w, a) after it and during it.
        """
        n, t, size = self.steps, self.tick_s, _STATES + 2
        held = self._model.at(speeds[:-1])
        self._a, self._b = np.zeros((n, _STATES, _STATES)), np.zeros((n, _STATES, 2))
        self._a[:, :_U, :_U], self._b[:, :_U, 0] = held[:, :, :_U], held[:, :, _U]
        self._a[:, _U, _U], self._b[:, _U, 1] = 1.0, t
        self._a[:, _THETA, _U] = -curvatures * t
        # A wheel angle costs as the lateral acceleration that it causes: little at low speed.
        square, axles = np.maximum(speeds[:-1], 0.1) ** 2, self.axles
        gains = 1.0 / (axles.wheelbase_m / square + axles.understeer_gradient)
        self._change_weights = np.full((n, 2), self.acceleration_change_weight)
        lateral_weights = self.lateral_change_weight * gains**2
        self._change_weights[:, 0] = self.wheel_change_weight + lateral_weights
        weights = self.cross_track_weight, self.heading_weight, 0.0, 0.0, self.speed_weight
        self._weights = np.tile(weights, (n, 1))
        self._weights[-1, : _THETA + 1] *= _TERMINAL
        p, a = np.zeros((n, size, n, size)), np.zeros((n, _ROWS, n, size))
        z, inputs = slice(0, _STATES), slice(_STATES, size)
        dynamics, changes, limits = z, inputs, slice(size, _ROWS)
        identity, of_inputs = np.eye(_STATES), np.eye(2)
        for k in range(n):
            p[k, z, k, z] = np.diag(self._weights[k])
            p[k, inputs, k, inputs] = np.diag(self._change_weights[k : k + 2].sum(axis=0))
            a[k, dynamics, k, z], a[k, dynamics, k, inputs] = identity, -self._b[k]
            a[k, changes, k, inputs] = a[k, limits, k, inputs] = of_inputs
            if k > 0:
                p[k - 1, inputs, k, inputs] = -np.diag(self._change_weights[k])
                a[k, dynamics, k - 1, z], a[k, changes, k - 1, inputs] = -self._a[k], -of_inputs
        return {"p": p.reshape(n * size, -1), "a": a.reshape(n * _ROWS, -1)}
