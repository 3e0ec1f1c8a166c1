"""The driver of the lab: it plans the next second in each tick, with what you have written."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable

import numpy as np

from sdc_common.driving import Observation, Path
from sdc_common.geometry.angles import wrap_angle
from sdc_common.geometry.polyline import Polyline
from sdc_mpc.limits import limits
from sdc_mpc.model import WHEELBASE_M, discretized, linearized, rates
from sdc_mpc.program import changes, cost, dynamics
from sdc_mpc.solver import solution
from sdc_sim.physics.ackermann import AckermannTarget

TICK_S = 0.05
DELAY_TICKS = 2  # a command acts this many ticks after the odometry that it answers
# The tyres slip. Both values are per lateral acceleration [rad/(m/s^2)].
_UNDERSTEER = 0.0009  # wheel angle beyond that of the bend
_REAR_COMPLIANCE = 0.0062  # direction of the motion beyond that of the body
_REAR_M = 1.435  # distance from the rear axle to the centre
_LEAST = np.array([-0.6, -4.0])
_MOST = np.array([0.6, 2.0])
_CHANGE = np.array([0.1, 0.3])
# The speed loop of the car accelerates so much per difference of the speed [1/s].
_SPEED_GAIN = 1.5


@dataclass(frozen=True)
class Tuning:
    """What the driver wants, and what it knows."""

    # Of cross-track error, heading error and speed error
    weights: tuple[float, float, float] = (1.0, 1.0, 0.3)
    # Of the change of wheel angle and acceleration in a tick
    change_weights: tuple[float, float] = (40.0, 2.0)
    ticks: int = 20  # length of a plan
    delay_ticks: int = DELAY_TICKS  # the delay that it knows of


class PredictiveDriver:
    """Follows a line of points with planned speeds.

    Args:
        points_m: (N, 2) the path [m]
        speeds_mps: (N,) planned speed at each point
        tuning: what it wants
        limited: the function of TODO 6

    Attributes:
        place_m: where it is along the path
        cross_track_m: how far it is to the left of it
        command: its last wheel angle [rad] and acceleration [m/s^2]
    """

    path: Path | None = None
    reason = ""

    def __init__(
        self,
        points_m: np.ndarray,
        speeds_mps: np.ndarray,
        tuning: Tuning,
        limited: Callable = limits,
    ):
        self.line = Polyline(points_m.tolist())
        self._speeds_mps, self._tuning, self._limited = speeds_mps, tuning, limited
        self.place_m = self.cross_track_m = 0.0
        self.command = np.zeros(2)
        self._pending = [np.zeros(2)] * tuning.delay_ticks

    def step(self, observation: Observation) -> AckermannTarget:
        """Return the command that answers an observation."""
        seen = observation
        place = self.line.project(seen.x_m, seen.y_m, self.place_m, 5.0, 15.0)
        self.place_m, self.cross_track_m = place.s_m, place.cross_track_m
        slip = self._slip(seen.speed_mps, place.s_m)
        error = wrap_angle(seen.yaw_rad + slip - place.heading_rad)
        state = np.array([place.cross_track_m, error, seen.speed_mps])
        s_m = place.s_m
        for wheel, acceleration in self._pending:  # until the new command acts
            curvature = self.line.curvature_at(s_m)
            wheel -= _UNDERSTEER * curvature * state[2] ** 2
            s_m += state[2] * TICK_S
            state = state + TICK_S * rates(state, wheel, acceleration, curvature)
        self.command = self.plan(state, s_m)[0]
        self._pending = [*self._pending, self.command][1:] if self._pending else []
        wheel, acceleration = self.command.tolist()
        target_mps = max(seen.speed_mps + acceleration / _SPEED_GAIN, 0.0)
        return AckermannTarget(wheel, 0.0, target_mps, abs(acceleration))

    def plan(self, state: np.ndarray, s_m: float) -> np.ndarray:
        """Return the inputs (n, 2) with the least cost, from a state at a place of the path."""
        tuning, ticks = self._tuning, self._tuning.ticks
        places = s_m + state[2] * TICK_S * np.arange(ticks + 1)
        curvatures = np.array([self.line.curvature_at(place) for place in places[:-1].tolist()])
        references = np.zeros((ticks, 3))
        references[:, 2] = np.interp(places[1:], self.line.s, self._speeds_mps)
        bends = np.zeros((ticks, 2))
        bends[:, 0] = np.arctan(WHEELBASE_M * curvatures) + _UNDERSTEER * curvatures * state[2] ** 2
        ad, bd = discretized(*linearized(max(state[2], 1.0), curvatures[0]), TICK_S)
        p, q = cost(
            np.array(tuning.weights), np.array(tuning.change_weights), references, self.command
        )
        rows, right = dynamics(ad, bd, state, bends)
        lower, upper = self._limited(_LEAST, _MOST, _CHANGE, self.command, ticks)
        of_inputs = np.vstack([np.eye(2 * ticks), changes(ticks)])
        x = solution(
            p,
            q,
            np.vstack([rows, np.hstack([np.zeros((4 * ticks, 3 * ticks)), of_inputs])]),
            np.concatenate([right, lower]),
            np.concatenate([right, upper]),
        )
        return x[3 * ticks :].reshape(ticks, 2)

    def _slip(self, speed_mps: float, s_m: float) -> float:
        """Return the direction of the motion minus that of the body, in a steady bend [rad]."""
        curvature = self.line.curvature_at(s_m)
        return math.asin(_REAR_M * curvature) - _REAR_COMPLIANCE * curvature * speed_mps**2
