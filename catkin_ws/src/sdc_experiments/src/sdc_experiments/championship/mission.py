"""What a driver gets before a drive, and the car that it becomes a part of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Mapping

import numpy as np

from sdc_common.driving import Observation
from sdc_common.planning.stop_line import StopLine
from sdc_experiments.closed_loop import SteeringSource, car_with, function_planner, own_planner
from sdc_map.global_planner import GlobalPlanner
from sdc_map.network_file import load_network
from sdc_package.car import Car, PathPlanner

# What a class Driver can have: the whole car, or a part of ours.
PARTS = ("step", "plan", "score", "wheel_angle")


@dataclass(frozen=True)
class DriverMission:
    """What a driver knows about a drive.

    Attributes:
        league: control, driving or traffic
        waypoints_m: (N, 2) points on the middle of the lane, in the map [m]
        first: the first observation
        planner: parameters of our local planner, such as planned_speed_mps
        stop_lines: stop line of each traffic light by its id
        map: path of the map of streets, "" without one
        goals: places on the map to reach one after the other [m]
    """

    league: str
    waypoints_m: np.ndarray
    first: Observation
    planner: Mapping[str, Any]
    stop_lines: Mapping[int, StopLine] = field(default_factory=dict)
    map: str = ""
    goals: tuple = ()

    def default_planner(self, **options: Any) -> PathPlanner:
        """Return our planner for this mission; `options` replace parameters of `planner`."""
        missions = None
        if self.map:
            missions = GlobalPlanner(load_network(self.map))
            missions.drive_to(self.goals)
        limits = {**self.planner, **options}
        return own_planner(limits, self.waypoints_m, self.stop_lines, missions, self.first)[0]

    def default_car(self, steering: SteeringSource | None = None, **options: Any) -> Car:
        """Return our car for this mission, such as `mission.default_car("lqr_feedforward")`.

        Args:
            steering: steering method, None for that of config/simple_controller.yaml
            options: parameters that replace those of this file
        """
        return car_with(self.default_planner(), steering, options)


def car_of(driver: Any, mission: DriverMission) -> Any:
    """Return the car that a driver is, or that it is a part of: an object with `step`.

    Raises:
        TypeError: the driver has no method of PARTS
    """
    if hasattr(driver, "step"):
        return driver
    has_plan, scores, steers = (hasattr(driver, name) for name in PARTS[1:])
    if not (has_plan or scores or steers):
        raise TypeError(f"class Driver has none of the methods {', '.join(PARTS)}")
    own = {"score_function": driver.score} if scores else {}
    planner = function_planner(driver.plan) if has_plan else mission.default_planner(**own)
    return car_with(planner, driver if steers else None)
