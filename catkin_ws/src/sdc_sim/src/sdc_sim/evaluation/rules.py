"""What a drive is evaluated by: the referee's parameters and the local planner's limits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from sdc_common.planning.speed_profile import SpeedLimits
from sdc_common.validation import check_positive

# Fields of SpeedLimits and the local planner's parameters with the same meaning.
_PLANNER_PARAMETERS = {
    "cruise_mps": "planned_speed_mps",
    "lateral_mps2": "lateral_acceleration_mps2",
    "acceleration_mps2": "acceleration_mps2",
    "braking_mps2": "braking_mps2",
    "lateral_jerk_mps3": "lateral_jerk_mps3",
}
_POSITIVE = ("off_route_m", "off_route_s", "blocked_s", "finish_within_m", "lane_width_m")


class EvaluationRules(NamedTuple):
    """The parameters of config/referee.yaml that decide about a drive."""

    off_route_m: float
    off_route_s: float
    blocked_s: float
    finish_within_m: float
    timeout_ratio: float
    timeout_margin_s: float
    lane_width_m: float
    car_front_m: float
    planner: dict  # limits of the local planner by its parameter names
    assumed: list  # names of those limits that /local_planner does not provide
    finish_at_rest: bool = True  # whether the car must stop at the end of the route
    # Whether the drive continues along a mission that is published later.
    new_missions: bool = False
    map: str = ""  # map of streets, whose rules apply; "" without one

    @classmethod
    def read(cls, parameter: Callable[[str], Any]) -> EvaluationRules:
        """Return the rules by the parameters of config/referee.yaml, with assumed limits.

        Raises:
            ValueError: a limit is not positive, or `finish_at_rest` or `new_missions` is no boolean
        """
        planner = parameter("assumed_planner")
        own = {name: parameter(name) for name in cls._fields if name not in ("planner", "assumed")}
        check_positive(**{name: own[name] for name in _POSITIVE})
        for name in ("finish_at_rest", "new_missions"):
            if not isinstance(own[name], bool):
                raise ValueError(f"{name} must be true or false, got {own[name]!r}")
        return cls(planner=planner, assumed=list(planner), **own)

    def speed_limits(self) -> SpeedLimits:
        """Return the local planner's limits as limits of a speed profile."""
        return SpeedLimits(
            **{field: self.planner[name] for field, name in _PLANNER_PARAMETERS.items()}
        )

    def timeout_s(self, ideal_duration_s: float) -> float:
        """Return the simulated time that ends a drive whose ideal duration is given [s]."""
        return self.timeout_ratio * ideal_duration_s + self.timeout_margin_s
