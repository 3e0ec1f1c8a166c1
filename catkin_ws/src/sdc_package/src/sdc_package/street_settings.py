"""Parameters of the street planner; config/street_planner.yaml says what each is, and why."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, Callable, Mapping

from sdc_common.configuration import node_config
from sdc_common.validation import check_non_negative, suggestion
from sdc_package.planner_settings import PlannerSettings

# Maximum yaw rate on a map, which limits the speed in bends tighter than 5 m [rad/s]. Above 0.95,
# nuPlan calls it uncomfortable, and steering adds a sixth.
_YAW_RATE_RADPS = 0.8


@dataclass(frozen=True)
class StreetSettings:
    """All that the street planner is told; a section has the numbers of the file by their names."""

    planner: PlannerSettings
    streets: SimpleNamespace  # rules and distances
    prediction: SimpleNamespace  # what others will do; `weights` is a dictionary
    proposals: SimpleNamespace  # what the car could do
    weights_m: Mapping[str, float]  # the section `score`: name of each term, and its weight [m]
    score_function: Any  # a score of your own, see `behaviour.score.load_score`

    @classmethod
    def read(cls, parameter: Callable[[str], Any]) -> StreetSettings:
        """Read the parameters of local_planner.yaml and street_planner.yaml.

        Args:
            parameter: function that returns the value of a parameter

        Raises:
            TypeError: a section lacks a parameter or has an unknown one
            ValueError: a value is out of range
        """
        shipped = node_config("sdc_package", "street_planner")
        names = "streets", "prediction", "proposals", "score"
        sections = {name: _checked(name, parameter(name), shipped[name]) for name in names}
        weights_m = sections.pop("score")
        spaces = {name: SimpleNamespace(**section) for name, section in sections.items()}
        planner, score_function = PlannerSettings.read(parameter), parameter("score_function")
        limits = replace(planner.limits, yaw_rate_radps=_YAW_RATE_RADPS)
        planner = replace(planner, limits=limits)
        return cls(planner, weights_m=weights_m, score_function=score_function, **spaces)

    @property
    def front_m(self) -> float:
        """Distance from the car's centre to its front [m]."""
        return self.planner.obstacles.car_front_m

    @property
    def width_m(self) -> float:
        """Width of the car [m]."""
        return self.planner.obstacles.car_width_m

    @property
    def braking_mps2(self) -> float:
        """Usual deceleration of the car [m/s^2]."""
        return self.planner.limits.braking_mps2


def _checked(name: str, section: dict[str, Any], shipped: dict[str, Any]) -> dict[str, Any]:
    """Return a section if it has the keys of the shipped one, and numbers that are not negative."""
    for key in section.keys() ^ shipped.keys():
        known = suggestion(key, shipped, "delete it") if key in section else "add it"
        raise TypeError(f"{name}/{key}: {known}")
    for key, value in section.items():
        if isinstance(shipped[key], dict):
            _checked(f"{name}/{key}", value, shipped[key])
        else:
            check_non_negative(**{f"{name}/{key}": value})
    return section
