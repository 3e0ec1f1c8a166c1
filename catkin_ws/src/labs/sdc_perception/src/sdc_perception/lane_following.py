"""The path that follows a lane, with target speeds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from sdc_common.planning.speed_profile import SpeedLimits, limited_speeds
from sdc_common.validation import check_between, check_positive
from sdc_perception.lane_curve import STEP_M
from sdc_perception.lane_tracker import TrackedLane

_SHORTEST_M = 2.0


@dataclass(frozen=True)
class FollowingSettings:
    """Limits of the path."""

    limits: SpeedLimits  # limits of the speed
    behind_m: float  # length of the path behind the car [m]
    lookahead_m: float  # longest path ahead [m]
    confident: float  # confidence from which the speed is not reduced, 0..1
    unsure: float  # confidence at which the car stops, 0..1

    @classmethod
    def read(cls, parameter: Callable[[str], Any]) -> FollowingSettings:
        """Return the settings, given a function that returns one of config/lane_follower.yaml.

        Raises:
            ValueError: a value is out of range
        """
        cruise_mps = parameter("planned_speed_mps")
        limits = SpeedLimits(
            cruise_mps,
            parameter("lateral_acceleration_mps2"),
            parameter("acceleration_mps2"),
            parameter("braking_mps2"),
            parameter("lateral_jerk_mps3"),
            # The path begins behind the car, which drives already.
            start_mps=cruise_mps,
        )
        names = ("behind_m", "lookahead_m", "confident", "unsure")
        return cls(limits, *map(parameter, names))

    def __post_init__(self):
        check_positive(behind_m=self.behind_m, lookahead_m=self.lookahead_m)
        check_between(0.0, 1.0, confident=self.confident, unsure=self.unsure)
        if not self.unsure < self.confident:
            raise ValueError(
                f"unsure must be less than confident, got {self.unsure} and {self.confident}"
            )


def lane_path(lane: TrackedLane, settings: FollowingSettings) -> np.ndarray:
    """Return the path (N, 3) of x [m], y [m] and speed [m/s] along a lane.

    The car can stop within the visible part of the lane. It is slower in bends, and where the
    detector is not confident.
    """
    s_m = lane.first_m + STEP_M * np.arange(len(lane.points_m))
    end_m = max(_SHORTEST_M, path_end(lane.visible_m, settings.lookahead_m))
    kept = (s_m > -settings.behind_m) & (s_m <= end_m)
    speeds = limited_speeds(s_m[kept], lane.curvatures_1pm[kept], settings.limits)[0]
    share = speed_share(lane.confidence, settings.unsure, settings.confident)
    return np.column_stack([lane.points_m[kept], speeds * share])


def path_end(visible_m: float, lookahead_m: float) -> float:
    """Return how far ahead the path reaches [m]. The car can always stop before its end."""
    # TODO 11: only as far as the lane is known (until then: return 0.0)
    return min(visible_m, lookahead_m)
    # ----------------------------------------------------------------------------


def speed_share(confidence: float, unsure: float, confident: float) -> float:
    """Return the share of the planned speed that a confidence allows, 0..1.

    Args:
        confidence: how well the lane is known, 0..1
        unsure: confidence at which the car stops
        confident: confidence from which it drives at full speed
    """
    # TODO 12: 0 at `unsure`, 1 at `confident`, linear between them (until then: return 0.0)
    return min(max((confidence - unsure) / (confident - unsure), 0.0), 1.0)
    # ----------------------------------------------------------------------------


def stopping_path(x_m: float, y_m: float, yaw_rad: float) -> np.ndarray:
    """Return a straight path (2, 3) of x [m], y [m] and speed 0 ahead of a pose."""
    forward = np.array([math.cos(yaw_rad), math.sin(yaw_rad)])
    start = np.array([x_m, y_m])
    return np.column_stack([np.vstack([start, start + _SHORTEST_M * forward]), np.zeros(2)])
