"""Parameters of the planners, see config/local_planner.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable

from sdc_common.planning.speed_profile import SpeedLimits
from sdc_common.validation import check_positive
from sdc_package.obstacle_prediction import ObstacleMargins
from sdc_package.traffic_lights import TrafficLightMargins


@dataclass(frozen=True)
class PlannerSettings:
    """Parameters of the local planner."""

    limits: SpeedLimits  # limits of the speed profile
    lookahead_m: float  # least length of the planned path [m]
    lookahead_s: float  # least time for which it reaches at the planned speed [s]
    join_within_m: float  # maximum distance from the route at which the car joins it [m]
    obstacles: ObstacleMargins  # margins to obstacles
    traffic_lights: TrafficLightMargins  # margins at traffic lights

    def __post_init__(self):
        names = ("lookahead_m", "lookahead_s", "join_within_m")
        check_positive(**{name: getattr(self, name) for name in names})

    @classmethod
    def read(cls, parameter: Callable[[str], Any]) -> PlannerSettings:
        """Read the parameters of config/local_planner.yaml.

        Args:
            parameter: function that returns the value of a parameter

        Raises:
            TypeError: a section lacks a parameter or has an unknown one
            ValueError: a value is out of range
        """
        limits = SpeedLimits(
            cruise_mps=parameter("planned_speed_mps"),
            lateral_mps2=parameter("lateral_acceleration_mps2"),
            acceleration_mps2=parameter("acceleration_mps2"),
            braking_mps2=parameter("braking_mps2"),
            lateral_jerk_mps3=parameter("lateral_jerk_mps3"),
        )
        obstacles = ObstacleMargins(**parameter("caution"))
        lights = TrafficLightMargins(**parameter("traffic_lights"))
        lookahead = parameter("lookahead_m"), parameter("lookahead_s")
        return cls(limits, *lookahead, parameter("join_within_m"), obstacles, lights)
