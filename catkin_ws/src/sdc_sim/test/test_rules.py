"""Tests of the rules that a drive is evaluated by."""

import pytest

from sdc_common.planning.speed_profile import SpeedLimits
from sdc_sim.evaluation.rules import EvaluationRules

PARAMETERS = {
    "off_route_m": 3.0,
    "off_route_s": 5.0,
    "blocked_s": 60.0,
    "finish_within_m": 4.0,
    "timeout_ratio": 2.0,
    "timeout_margin_s": 30.0,
    "lane_width_m": 3.5,
    "car_front_m": 3.8,
    "finish_at_rest": False,
    "new_missions": True,
    "map": "town.net.xml",
    "assumed_planner": {
        "planned_speed_mps": 11.0,
        "lateral_acceleration_mps2": 2.5,
        "acceleration_mps2": 1.5,
        "braking_mps2": 2.0,
        "lateral_jerk_mps3": 1.0,
        "curve_ahead_m": 20.0,
    },
}


def read(**changes):
    return EvaluationRules.read({**PARAMETERS, **changes}.__getitem__)


def test_each_rule_is_the_parameter_of_its_name():
    rules = read()._asdict()
    assert {**rules, "planner": 0, "assumed": 0} == {
        **{name: value for name, value in PARAMETERS.items() if name != "assumed_planner"},
        "planner": 0,
        "assumed": 0,
    }


def test_limits_of_the_planner_are_those_of_the_speed_profile():
    assert read().speed_limits() == SpeedLimits(
        cruise_mps=11.0,
        lateral_mps2=2.5,
        acceleration_mps2=1.5,
        braking_mps2=2.0,
        lateral_jerk_mps3=1.0,
    )


def test_timeout_is_the_ratio_of_the_ideal_duration_and_a_margin():
    assert read().timeout_s(100.0) == 230.0


@pytest.mark.parametrize(
    ("name", "value"), [("blocked_s", 0.0), ("finish_at_rest", "no"), ("new_missions", 1)]
)
def test_rule_with_a_wrong_value_is_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        read(**{name: value})
