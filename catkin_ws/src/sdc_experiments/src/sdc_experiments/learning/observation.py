"""What the environments show of a drive, and what they reward; docs/learning.md describes both."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sdc_common.geometry.route import Route
from sdc_common.planning.speed_profile import SpeedLimits, limited_speeds
from sdc_sim.road.random_routes import long_route

TICK_S = 0.05
# Places ahead of the car at which it sees curvature and speed limit [m].
AHEAD_M = (0.0, 2.0, 4.0, 7.0, 10.0, 15.0, 20.0, 30.0)
# Nothing is seen farther ahead [m].
HORIZON_M = 50.0
# The planner's limits of speed and lateral acceleration, and gentle braking before bends.
LIMITS = SpeedLimits(
    cruise_mps=10.0,
    lateral_mps2=3.0,
    acceleration_mps2=1e3,
    braking_mps2=2.0,
    lateral_jerk_mps3=6.0,
    start_mps=10.0,
)

# Name, lowest and highest value of each entry of an observation.
ENTRIES = (
    ("speed_mps", -100.0, 100.0),
    ("cross_track_m", -10.0, 10.0),
    ("heading_error_rad", -math.pi, math.pi),
    ("yaw_rate_radps", -20.0, 20.0),
    ("steer", -1.0, 1.0),
    *((f"curvature_{ahead:g}m", -5.0, 5.0) for ahead in AHEAD_M),
    *((f"speed_limit_{ahead:g}m_mps", 0.0, 100.0) for ahead in AHEAD_M),
    ("obstacle_ahead_m", -10.0, HORIZON_M),
    ("obstacle_left_m", -HORIZON_M, HORIZON_M),
    ("obstacle_speed_mps", -60.0, 60.0),
)
NAMES = tuple(name for name, _, _ in ENTRIES)
NO_OBSTACLE = (HORIZON_M, 0.0, 0.0)
ROAD_ENTRIES = slice(5, 5 + 2 * len(AHEAD_M))

OFF_ROAD_M = 3.5
FINISH_WITHIN_M = 2.0
STANDSTILL_MPS = 0.05
MAX_STANDSTILL_S = 10.0
FULL_PROGRESS_M = LIMITS.cruise_mps * TICK_S
SPEEDING_WEIGHT = 0.1
COMPLETED_REWARD = 100.0
FAILED_REWARD = -100.0


def random_route(random: np.random.Generator) -> np.ndarray:
    """Return the waypoints (301, 2) of a random route of 300 m."""
    return long_route(random, 300.0)[:301]


def road_rows(route: Route) -> np.ndarray:
    """Return curvatures and speed limits ahead of each metre of a route: (metres, 2 * places)."""
    speed, _ = limited_speeds(route.s, route.curvature, LIMITS)
    metres = np.arange(math.floor(route.length_m) + 2.0)
    places_m = np.minimum(metres[:, None] + np.array(AHEAD_M), route.length_m)
    curvature = np.interp(places_m, route.s, route.curvature)
    return np.hstack([curvature, np.interp(places_m, route.s, speed)])


def longest_s(route: Route) -> float:
    """Return the time after which a drive is truncated [s]."""
    return 30.0 + route.length_m / 3.0


def checked_action(action: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Return an action, or one of each car, as floats.

    Raises:
        ValueError: it has another shape, or is not finite
    """
    found = np.asarray(action, float)
    name = "action" if len(shape) == 1 else "actions"
    if found.shape != shape:
        raise ValueError(f"{name} must have the shape {shape}, not {found.shape}")
    if not np.isfinite(found).all():
        raise ValueError(f"{name} must be finite, got {found[~np.isfinite(found)][0]}")
    return found


def checked_render_mode(mode: str | None) -> str | None:
    """Return a mode; ValueError if it is none. Gymnasium shows "human" with rgb_array."""
    if mode not in (None, "rgb_array"):
        raise ValueError(
            f"render_mode must be human, with gymnasium.make, or rgb_array, got {mode!r}"
        )
    return mode
