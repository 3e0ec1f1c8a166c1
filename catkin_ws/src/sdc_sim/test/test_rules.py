"""Tests of the rules that a drive is evaluated by."""

import pytest

from sdc_common.planning.speed_profile import SpeedLimits
from sdc_sim.evaluation.rules import EvaluationRules

# Each number differs from all others.
NAMES = "off_route_m off_route_s blocked_s finish_within_m timeout_ratio timeout_margin_s"
LIMITS = "planned_speed_mps lateral_acceleration_mps2 acceleration_mps2 braking_mps2"
PARAMETERS = {name: 1.5 + number for number, name in enumerate(NAMES.split())}
PARAMETERS.update(lane_width_m=3.25, car_front_m=3.8, finish_at_rest=False, new_missions=True)
PLANNER = {name: 11.0 + number for number, name in enumerate(LIMITS.split())}
PLANNER.update(lateral_jerk_mps3=1.0, curve_ahead_m=20.0)
PARAMETERS.update(map="town.net.xml", assumed_planner=PLANNER)


def read(**changes):
    return EvaluationRules.read({**PARAMETERS, **changes}.__getitem__)


def test_each_rule_is_the_parameter_of_its_name():
    rules, expected = read()._asdict(), {**PARAMETERS}
    del rules["planner"], rules["assumed"], expected["assumed_planner"]
    assert rules == expected


def test_limits_of_the_planner_are_those_of_the_speed_profile():
    limits = {"cruise_mps": 11.0, "lateral_mps2": 12.0, "acceleration_mps2": 13.0}
    limits.update(braking_mps2=14.0, lateral_jerk_mps3=1.0)
    assert read().speed_limits() == SpeedLimits(**limits)


def test_timeout_is_the_ratio_of_the_ideal_duration_and_a_margin():
    assert read(timeout_ratio=2.0, timeout_margin_s=30.0).timeout_s(100.0) == 230.0


@pytest.mark.parametrize(
    ("name", "value"), [("blocked_s", 0.0), ("finish_at_rest", "no"), ("new_missions", 1)]
)
def test_rule_with_a_wrong_value_is_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        read(**{name: value})
