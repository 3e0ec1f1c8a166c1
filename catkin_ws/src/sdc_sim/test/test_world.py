import math
import os

import pytest

from sdc_sim.vehicle import Vehicle, VehicleCommand, load_vehicle
from sdc_sim.world import World

TESLA = os.path.join(os.path.dirname(__file__), "..", "config", "vehicles", "tesla_model3.yaml")


def world(patience_s=1.0):
    return World(Vehicle(load_vehicle(TESLA)), 0.05, patience_s)


def test_stamps_are_whole_ticks_without_drift():
    here = world()
    assert here.stamp == (0, 50_000_000)
    here.tick = 72_000_000
    assert here.stamp == (3_600_000, 0)


def test_car_waits_for_its_first_command_without_braking():
    here = world()
    for _ in range(100):
        here.advance()
    assert not here.silent
    assert here.vehicle.state.x_m == 0.0


@pytest.mark.parametrize(("patience_s", "stops"), [(1.0, True), (0.0, False)])
def test_silence(patience_s, stops):
    here = world(patience_s)
    for _ in range(60):
        here.obey(VehicleCommand(throttle=0.8))
        here.advance()
    for _ in range(100):
        here.advance()
    assert here.silent == stops
    assert (here.vehicle.state.speed_mps == 0.0) == stops


def test_refused_command_leaves_the_last_one_in_force():
    here = world()
    here.obey(VehicleCommand(throttle=0.8))
    with pytest.raises(ValueError, match="throttle|finite|nan"):
        here.obey(VehicleCommand(throttle=math.nan))
    for _ in range(15):
        here.advance()
    assert here.vehicle.state.speed_mps > 1.0


def test_out_of_range_is_clamped_and_said():
    here = world()
    assert here.obey(VehicleCommand(throttle=7.0))
    assert not here.obey(VehicleCommand(throttle=0.7))


@pytest.mark.parametrize(("tick_s", "patience_s"), [(0.0, 1.0), (-1.0, 1.0), (math.nan, 1.0), (0.05, -1.0)])
def test_senseless_times_are_refused(tick_s, patience_s):
    with pytest.raises(ValueError, match="_s must"):
        World(Vehicle(load_vehicle(TESLA)), tick_s, patience_s)
