"""The highest speed on each point of a route that keeps every limit."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sdc_common.validation import check_positive

# In a bend the curvature varies a little, and with it the speed. Above this share of the speed that
# a point itself allows, braking and acceleration are no reasons.
_NEARLY = 0.98


@dataclass(frozen=True)
class SpeedLimits:
    """Limits of a speed profile, all positive."""

    cruise_mps: float  # maximum speed [m/s]
    lateral_mps2: float  # maximum lateral acceleration [m/s^2]
    acceleration_mps2: float  # maximum acceleration [m/s^2]
    braking_mps2: float  # maximum deceleration [m/s^2]
    # Maximum rate of lateral acceleration, may be infinite [m/s^3]
    lateral_jerk_mps3: float = math.inf
    yaw_rate_radps: float = math.inf  # maximum yaw rate, may be infinite [rad/s]
    # Target speed on the first point, which a car at rest needs to set off [m/s]
    start_mps: float = 0.5

    def __post_init__(self):
        limits = dict(vars(self))
        for name in ("lateral_jerk_mps3", "yaw_rate_radps"):
            if limits[name] == math.inf:
                del limits[name]
        check_positive(**limits)


def limited_speeds(
    s_m: np.ndarray,
    curvature_1pm: np.ndarray,
    limits: SpeedLimits,
    road_mps: np.ndarray | float = math.inf,
) -> tuple[np.ndarray, list[str]]:
    """Return the highest speeds that keep every limit and end at rest, and what limits each.

    First limit the speed by the lateral acceleration, the yaw rate and the lateral jerk. Then limit
    it by braking in a backward pass and by acceleration in a forward pass, each with the part of
    the friction ellipse that the lateral acceleration leaves.

    Args:
        s_m: (N,) arc lengths of the points of a path [m]
        curvature_1pm: (N,) its curvature there [1/m]
        limits: the limits
        road_mps: (N,) speed limit of the road there [m/s]

    Returns:
        (N,) speeds at the points [m/s], and a name of speed_reasons for each, see report_page.yaml

    Reference: N. R. Kapania, J. Subosits and J. C. Gerdes, A Sequential Two-Step Algorithm for Fast
    Generation of Vehicle Racing Trajectories, J. Dyn. Sys. Meas. Control 138(9), 2016, section 3.
    """
    curvature = np.abs(curvature_1pm)
    some = np.maximum(curvature, 1e-9)
    bend = np.minimum(np.sqrt(limits.lateral_mps2 / some), limits.yaw_rate_radps / some)
    change = np.abs(np.gradient(curvature_1pm, s_m))
    turn = np.cbrt(limits.lateral_jerk_mps3 / np.maximum(change, 1e-9))
    lateral = np.minimum(bend, turn)
    straight = np.minimum(limits.cruise_mps, road_mps)
    speed = np.minimum(lateral, straight).tolist()
    local_reasons = np.where(lateral < straight, "bend", "cruise").tolist()
    local, reasons = list(speed), list(local_reasons)
    steps = np.diff(s_m).tolist()
    curvatures = curvature.tolist()
    speed[-1], reasons[-1] = 0.0, "end_of_route"
    if limits.start_mps < speed[0]:
        speed[0], reasons[0] = limits.start_mps, "accelerating"
    for i in range(len(steps) - 1, -1, -1):
        before = _reachable(
            speed[i + 1], curvatures[i + 1], steps[i], limits.braking_mps2, limits.lateral_mps2
        )
        if before < speed[i]:
            at_end = reasons[i + 1] == "end_of_route"
            speed[i], reasons[i] = before, "end_of_route" if at_end else "braking_ahead"
    for i, step in enumerate(steps):
        after = _reachable(
            speed[i], curvatures[i], step, limits.acceleration_mps2, limits.lateral_mps2
        )
        if after < speed[i + 1]:
            speed[i + 1], reasons[i + 1] = after, "accelerating"
    for i, limit in enumerate(local):
        if speed[i] > _NEARLY * limit:
            reasons[i] = local_reasons[i]
    return np.array(speed), reasons


def _reachable(
    speed: float, curvature: float, step: float, longitudinal: float, lateral: float
) -> float:
    used = min(1.0, speed * speed * curvature / lateral)
    return math.sqrt(speed * speed + 2.0 * longitudinal * math.sqrt(1.0 - used * used) * step)
