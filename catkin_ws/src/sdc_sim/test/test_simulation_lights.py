"""Traffic lights of a simulation show their phases at the right ticks."""

import os

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


def test_observation_shows_the_phases_and_a_reset_starts_them_again():
    simulation = Simulation(
        Vehicle(load_vehicle(TESLA)),
        0.05,
        1.0,
        lights=TrafficLights([TrafficLightPlan(50.0, 0.0, 0.0, PHASES)]),
    )
    shown = []
    for _ in range(80):
        shown.append(simulation.snapshot.traffic_lights[0].state)
        simulation.step()
    assert shown == [RED] * 40 + [GREEN] * 20 + [YELLOW] * 10 + [OFF] * 10
    for _ in range(45):
        simulation.step()
    assert simulation.snapshot.traffic_lights[0].state == GREEN
    simulation.reset()
    assert simulation.snapshot.traffic_lights[0] == (FIRST_ID, 54.0, -2.7, 0.0, RED)
