"""Traffic lights show their phases, on a pole to the right of the lane."""

import math

import numpy as np
import pytest

from sdc_sim.physics.traffic_lights import (
    FIRST_ID,
    GREEN,
    OFF,
    RED,
    YELLOW,
    TrafficLightPlan,
    light_states,
)

PHASES = (("red", 2.0), ("green", 1.0), ("yellow", 0.5), ("off", 0.5))


@pytest.mark.parametrize(
    ("elapsed_s", "state"),
    [*((0.0, RED), (1.95, RED), (2.0, GREEN), (2.95, GREEN), (3.0, YELLOW), (3.5, OFF))]
    + [(4.0, RED), (282.0, GREEN)],
)
def test_phases_follow_each_other_and_repeat(elapsed_s, state):
    assert TrafficLightPlan(0.0, 0.0, 0.0, PHASES).state(elapsed_s) == state


@pytest.mark.parametrize(
    ("offset_s", "state"),
    [
        (2.5, GREEN),
        (-0.5, OFF),
        # So little before the first phase that the remainder is rounded to the sum of all phases.
        (float(np.nextafter(-1e-6, -1.0)), OFF),
    ],
)
def test_offset_is_the_position_in_the_phases_at_the_start(offset_s, state):
    assert TrafficLightPlan(0.0, 0.0, 0.0, PHASES, offset_s).state(0.0) == state


@pytest.mark.parametrize(
    ("heading_deg", "x_m", "y_m"),
    [(0.0, 14.0, 17.3), (90.0, 12.7, 24.0), (180.0, 6.0, 22.7), (-90.0, 7.3, 16.0)],
)
def test_pole_is_beyond_the_stop_line_and_to_the_right(heading_deg, x_m, y_m):
    plan = TrafficLightPlan(10.0, 20.0, math.radians(heading_deg), PHASES)
    (light,) = light_states([plan], 0.0)
    assert (light.x_m, light.y_m) == pytest.approx((x_m, y_m), abs=1e-9)
    assert plan.line_m(light) == pytest.approx((4.0, -2.7), abs=1e-9), "seen by who stops there"


def test_every_light_has_its_own_id_place_and_phases():
    other = TrafficLightPlan(0.0, 30.0, math.pi, (("yellow", 1.0), ("green", 1.0)))
    first, second = light_states([TrafficLightPlan(50.0, 0.0, 0.0, PHASES), other], 1.5)
    assert first[:5] == (FIRST_ID, 54.0, -2.7, 0.0, RED)
    assert second[:4] == pytest.approx((FIRST_ID + 1, -4.0, 32.7, math.pi), abs=1e-9)
    assert second.state == GREEN
