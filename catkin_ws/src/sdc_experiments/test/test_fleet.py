"""A fleet moves as single vehicles do."""

import numpy as np
import pytest

from sdc_common.driving import Command
from sdc_experiments.configuration import vehicle_preset
from sdc_experiments.fleet import FIELDS, VehicleFleet
from sdc_sim.physics.vehicle import Vehicle

pytestmark = pytest.mark.slow(2)

# Enough for two threads, and no more.
COUNT = 130
TICK_S = 0.05


def random_commands(random):
    """Return throttle, brake and steer of all vehicles; some pedals are released."""
    throttle, brake = random.random((2, COUNT)) * (random.random((2, COUNT)) < [[0.6], [0.3]])
    return throttle, brake, random.uniform(-1.0, 1.0, COUNT) * random.choice([0.0, 0.1, 1.0], COUNT)


@pytest.mark.parametrize(
    ("preset", "friction", "threads"), [("tesla_model3", 0.7, 1), ("ford_escort", 1.0, 8)]
)
def test_fleet_equals_single_vehicles(preset, friction, threads):
    parameters = vehicle_preset(preset)
    random = np.random.default_rng(7)
    fleet = VehicleFleet(parameters, COUNT, friction, threads)
    vehicles = [Vehicle(parameters, friction) for _ in range(COUNT)]
    yaw = random.uniform(-3.0, 3.0, COUNT)
    fleet.reset(np.arange(COUNT), yaw, -yaw, yaw)
    for vehicle, value in zip(vehicles, yaw):
        vehicle.reset(value, -value, value)
    for tick in range(60):
        if tick % 10 == 0:
            throttle, brake, steer = random_commands(random)
        fleet.step(throttle, brake, steer, TICK_S)
        for i, vehicle in enumerate(vehicles):
            vehicle.step(Command(throttle[i], steer[i], brake[i]), TICK_S)
    assert fleet.state["speed_mps"].max() > 3.0
    assert (fleet.state["speed_mps"] == 0.0).any()
    for name in FIELDS:
        expected = [getattr(vehicle.state, name) for vehicle in vehicles]
        np.testing.assert_array_equal(fleet.state[name], expected)
