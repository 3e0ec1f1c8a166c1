"""Dead reckoning against the physics of the simulator."""

import math

import pytest

from sdc_common.configuration import node_config
from sdc_common.driving import Command
from sdc_perception.dead_reckoning import DeadReckoning
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.physics.vehicle_parameters import load_vehicle
from sdc_sim.yaml_document import config_path

TICK_S = 0.05


def drive(steer):
    car = Vehicle(load_vehicle(config_path("vehicles/tesla_model3.yaml")))
    parameters = node_config("sdc_perception", "dead_reckoning")
    motion = DeadReckoning(parameters["rear_m"], parameters["rear_compliance"])
    for tick in range(300):
        motion.update(car.state.speed_mps, car.state.yaw_rate_radps, TICK_S if tick else 0.0)
        state, throttle = car.state, 0.5 if car.state.speed_mps < 6.0 else 0.3
        last = (state.x_m, state.y_m, state.yaw_rad)
        car.step(Command(throttle, steer * math.sin(tick / 40.0)), TICK_S)
    return motion, last


@pytest.mark.parametrize("steer", [0.0, 0.2, -0.4])
def test_pose_is_that_of_the_car(steer):
    motion, (x, y, yaw) = drive(steer)
    assert math.hypot(x, y) > 20.0
    assert math.dist((motion.x_m, motion.y_m), (x, y)) < 0.006 * math.hypot(x, y)
    assert motion.yaw_rad == pytest.approx(yaw, abs=0.01)
