"""Traffic lights show their phases at the right ticks."""

import os

import pytest

from sdc_sim.physics.traffic_lights import (
    FIRST_ID,
    GREEN,
    OFF,
    RED,
    YELLOW,
    TrafficLightPlan,
    TrafficLights,
)
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.physics.vehicle_parameters import load_vehicle
from sdc_sim.simulation.simulation import Simulation

TESLA = os.path.join(
    os.path.dirname(os.path.abspath(__file__)), "..", "config", "vehicles", "tesla_model3.yaml"
)
PHASES = (("red", 2.0), ("green", 1.0), ("yellow", 0.5), ("off", 0.5))


@pytest.mark.parametrize(
    ("elapsed_s", "state"),
    [
        (0.0, RED),
        (1.95, RED),
        (2.0, GREEN),
        (2.95, GREEN),
        (3.0, YELLOW),
        (3.5, OFF),
        (4.0, RED),
        (282.0, GREEN),
    ],
)
def test_phases_follow_each_other_and_repeat(elapsed_s, state):
    assert TrafficLightPlan(0.0, 0.0, 0.0, PHASES).state(elapsed_s) == state


def test_offset_is_the_position_in_the_phases_at_the_start():
    assert TrafficLightPlan(0.0, 0.0, 0.0, PHASES, offset_s=2.5).state(0.0) == GREEN
    assert TrafficLightPlan(0.0, 0.0, 0.0, PHASES, offset_s=-0.5).state(0.0) == OFF


def test_observation_shows_the_phases_and_a_reset_starts_them_again():
    simulation = Simulation(
        Vehicle(load_vehicle(TESLA)),
        0.05,
        1.0,
        lights=TrafficLights([TrafficLightPlan(50.0, 0.0, 0.0, PHASES)]),
    )
    shown = []
    for _ in range(80):
        shown.append(simulation.observation.traffic_lights[0].state)
        simulation.step()
    assert shown == [RED] * 40 + [GREEN] * 20 + [YELLOW] * 10 + [OFF] * 10
    for _ in range(45):
        simulation.step()
    assert simulation.observation.traffic_lights[0].state == GREEN
    simulation.reset()
    assert simulation.observation.traffic_lights[0] == (FIRST_ID, 54.0, -2.7, 0.0, RED)
