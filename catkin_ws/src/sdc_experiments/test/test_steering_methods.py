"""Drive the packaged route with every steering method: planner, controller and physics, no ROS."""

import importlib.util
import math

import numpy as np
import pytest

from sdc_experiments.closed_loop import car_with, drive_result
from sdc_experiments.configuration import node_parameters, vehicle_preset
from sdc_package.actuation import SteeringMap
from sdc_package.car import MissionDriver
from sdc_package.local_planner import PlannerSettings
from sdc_package.steering.axles import Axles
from sdc_package.steering.loader import METHODS
from sdc_sim.evaluation.route_progress import COMPLETED
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.simulation.snapshot import Snapshot

pytestmark = pytest.mark.slow(17)
METHODS = [one for one in METHODS if one != "mpc" or importlib.util.find_spec("osqp")]

CONFIG = node_parameters("simple_controller")
TICK_S = 0.05

# Root mean square and maximum of the cross-track error of the centre [m], measured and rounded up.
BOUNDS_M = {
    "stanley": (0.10, 0.60),  # the textbook law cuts tight bends
    "stanley_compensated": (0.02, 0.10),
    "pure_pursuit": (0.035, 0.17),
    "kinematic": (0.035, 0.16),
    "lqr": (0.04, 0.12),
    "lqr_feedforward": (0.02, 0.10),
    "mpc": (0.02, 0.10),
}


def test_configuration_of_the_controller_matches_the_default_car():
    car = vehicle_preset("tesla_model3")
    steering_map = SteeringMap(**CONFIG["steering"])
    for speed in np.linspace(0.0, 40.0, 81):
        half_angle = -0.5 * car.full_wheel_angle_rad(speed)
        assert steering_map.command(half_angle, speed)[0] == pytest.approx(0.5, rel=1e-3)
    axles = Axles(**CONFIG["axles"])
    assert (axles.front_m, axles.rear_m) == (car.front_axle_m, car.rear_axle_m)
    load = car.mass_kg * car.rear_axle_m / car.wheelbase_m
    front, rear = car.front_cornering_stiffness_n_per_rad, car.rear_cornering_stiffness_n_per_rad
    gyration_m = math.sqrt(car.yaw_inertia_kgm2 / car.mass_kg)
    found = axles.front_compliance, axles.rear_compliance, CONFIG["lqr"]["gyration_m"]
    assert found == pytest.approx((load / front, (car.mass_kg - load) / rear, gyration_m), rel=0.01)


def drive(method, y_m=0.0, yaw_rad=0.0, longest_s=400.0):
    """Drive from a start off the route; return cross-track errors [m], steers and status."""
    start = {"left_m": y_m, "turned_rad": yaw_rad}
    result = drive_result(steering=method, sim_options={"start": start}, longest_s=longest_s)
    return result.progress.column("cross_track_m"), result.commands[:, 2], result.progress.status


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("speed", [10.0, 25.0, 33.0])
def test_method_returns_to_a_straight_road_at_any_speed(method, speed):
    route = np.column_stack([np.arange(1301.0), np.zeros(1301)])
    limits = {**node_parameters("local_planner"), "planned_speed_mps": speed}
    car = car_with(MissionDriver(route, PlannerSettings.read(limits.__getitem__)), method)
    vehicle = Vehicle(vehicle_preset("tesla_model3"))
    vehicle.reset(600.0, 0.3, 0.0, speed)
    errors = []
    while vehicle.state.x_m < 900.0 and len(errors) < 1000:
        stamp_ns = (len(errors) + 1) * 50_000_000
        observation = Snapshot(stamp_ns, vehicle.state, vehicle.state).observation()
        vehicle.step(car.step(observation), TICK_S)
        errors.append(abs(vehicle.state.y_m))
    assert max(errors) < 0.35
    assert max(errors[-40:]) < 0.02


@pytest.mark.parametrize("method", METHODS)
def test_method_drives_the_packaged_route(method):
    errors, steers, status = drive(method)
    assert status == COMPLETED
    rms, worst = BOUNDS_M[method]
    assert math.sqrt(np.mean(errors**2)) < rms
    assert np.abs(errors).max() < worst
    power = np.abs(np.fft.rfft(steers - steers.mean())) ** 2
    fast = np.fft.rfftfreq(len(steers), TICK_S) > 1.0
    assert power[fast].sum() < 0.01 * power.sum(), "the steering oscillates"


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("y", "degrees"), [(2.0, 0.0), (-2.0, -30.0), (1.0, 30.0)])
def test_method_joins_the_route_from_an_offset(method, y, degrees):
    errors, _, _ = drive(method, y, math.radians(degrees), longest_s=15.0)
    assert np.abs(errors).max() < abs(y) + 1.75
    assert np.abs(errors[-40:]).max() < 0.1
