"""The greatest speed on each point of a route that keeps every limit."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sdc_common.geometry.route import Route
from sdc_common.validation import check_positive


@dataclass(frozen=True)
class SpeedLimits:
    """Limits of a speed profile: m/s, m/s^2 and m/s^3, all positive. `start_mps` is the target speed on the first point, which a car
    at rest needs in order to set off."""

    cruise_mps: float
    lateral_mps2: float
    acceleration_mps2: float
    braking_mps2: float
    lateral_jerk_mps3: float = math.inf
    start_mps: float = 0.5

    def __post_init__(self):
        check_positive(
            **{
                name: value
                for name, value in vars(self).items()
                if value != math.inf or name != "lateral_jerk_mps3"
            }
        )


def speed_profile(route: Route, limits: SpeedLimits) -> np.ndarray:
    """The greatest speeds (N,) m/s at the points of a route that keep every limit and end at rest.

    First the speed at which a bend asks for all of the lateral limit, and its beginning and end for all of the lateral jerk,
    then a backward pass for braking and a forward pass for accelerating, each with what the friction ellipse leaves beside the
    lateral acceleration.
    Source: N. R. Kapania, J. Subosits and J. C. Gerdes, A Sequential Two-Step Algorithm for Fast Generation of Vehicle
    Racing Trajectories, J. Dyn. Sys. Meas. Control 138(9), 2016, section 3.
    """
    curvature = np.abs(route.curvature)
    bend = np.sqrt(limits.lateral_mps2 / np.maximum(curvature, 1e-9))
    change = np.abs(np.gradient(route.curvature, route.s))
    turn = np.cbrt(limits.lateral_jerk_mps3 / np.maximum(change, 1e-9))
    speed = np.minimum(np.minimum(bend, turn), limits.cruise_mps).tolist()
    steps = np.diff(route.s).tolist()
    curvature = curvature.tolist()
    speed[-1] = 0.0
    speed[0] = min(speed[0], limits.start_mps)
    for i in range(len(steps) - 1, -1, -1):
        speed[i] = min(
            speed[i],
            _reachable(speed[i + 1], curvature[i + 1], steps[i], limits.braking_mps2, limits),
        )
    for i, step in enumerate(steps):
        speed[i + 1] = min(
            speed[i + 1], _reachable(speed[i], curvature[i], step, limits.acceleration_mps2, limits)
        )
    return np.array(speed)


def _reachable(
    speed: float, curvature: float, step: float, longitudinal: float, limits: SpeedLimits
) -> float:
    used = min(1.0, speed * speed * curvature / limits.lateral_mps2)
    return math.sqrt(speed * speed + 2.0 * longitudinal * math.sqrt(1.0 - used * used) * step)


def ideal_duration(route: Route, speed_mps: np.ndarray) -> float:
    """Seconds that a route takes with the given speeds (N,) m/s at its points and constant acceleration between them."""
    mean = 0.5 * (speed_mps[:-1] + speed_mps[1:])
    return float(np.sum(np.diff(route.s) / np.maximum(mean, 1e-3)))
