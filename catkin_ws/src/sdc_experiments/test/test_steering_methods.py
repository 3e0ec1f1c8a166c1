"""Every steering method drives the packaged route with the default car: planner, controller and physics without ROS."""

import math
import os

import numpy as np
import pytest
import yaml

from sdc_common.routes.waypoint_file import load_waypoints
from sdc_experiments.offline_drive import TICK_S, drive_offline
from sdc_package.actuation import SteeringMap
from sdc_package.steering.axles import Axles
from sdc_package.steering.method import METHODS
from sdc_sim.evaluation.route_progress import COMPLETED
from sdc_sim.physics.vehicle import Vehicle, VehicleCommand, load_vehicle

SRC = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
with open(
    os.path.join(SRC, "sdc_package", "config", "simple_controller.yaml"), encoding="utf-8"
) as config_file:
    CONFIG = yaml.safe_load(config_file)

# Root mean square and worst cross-track error of the centre, metres; measured and rounded up.
BOUNDS_M = {
    "stanley": (0.02, 0.10),
    "pure_pursuit": (0.035, 0.17),
    "kinematic": (0.035, 0.16),
    "lqr": (0.04, 0.12),
    "lqr_feedforward": (0.02, 0.10),
}


def test_the_controller_knows_the_car_that_it_drives():
    """Full steer at every speed, axles and tyres: the figures of the configuration are those of the default car."""
    car = load_vehicle(os.path.join(SRC, "sdc_sim", "config", "vehicles", "tesla_model3.yaml"))
    steering_map = SteeringMap(**CONFIG["steering"])
    for speed in np.linspace(0.0, 40.0, 81):
        assert steering_map.command(-0.5 * car.full_wheel_angle_rad(speed), speed)[
            0
        ] == pytest.approx(0.5, rel=1e-3)
    axles = Axles(**CONFIG["axles"])
    assert (axles.front_m, axles.rear_m) == (car.front_axle_m, car.rear_axle_m)
    front_load = car.mass_kg * car.rear_axle_m / car.wheelbase_m
    assert axles.front_compliance == pytest.approx(
        front_load / car.front_cornering_stiffness_n_per_rad, rel=0.01
    )
    assert axles.rear_compliance == pytest.approx(
        (car.mass_kg - front_load) / car.rear_cornering_stiffness_n_per_rad, rel=0.01
    )
    assert CONFIG["lqr"]["gyration_m"] == pytest.approx(
        math.sqrt(car.yaw_inertia_kgm2 / car.mass_kg), rel=0.01
    )


@pytest.mark.parametrize("speed", [2.0, 10.0, 20.0])
def test_a_wheel_angle_that_is_asked_for_is_the_one_that_comes(speed):
    vehicle = Vehicle(
        load_vehicle(os.path.join(SRC, "sdc_sim", "config", "vehicles", "tesla_model3.yaml"))
    )
    vehicle.reset(0.0, 0.0, 0.0, speed)
    for _ in range(10):
        steer, _ = SteeringMap(**CONFIG["steering"]).command(0.05, vehicle.state.speed_mps)
        vehicle.step(VehicleCommand(steer=steer), TICK_S)
    assert vehicle.state.wheel_angle_rad == pytest.approx(0.05, rel=0.01)


def drive(method, y_m=0.0, yaw_rad=0.0, longest_s=400.0):
    """(cross-track errors (N,) m, steer commands (N,), status) of a rehearsal from a start `y_m` and `yaw_rad` off."""
    route = load_waypoints(os.path.join(SRC, "sdc_common", "data", "waypoints.csv"))
    rehearsal = drive_offline(route, y_m, yaw_rad, steering_method=method, longest_s=longest_s)
    return (
        rehearsal.drive.column("cross_track_m"),
        np.array(rehearsal.steers),
        rehearsal.drive.status,
    )


@pytest.mark.parametrize("method", METHODS)
def test_drives_the_packaged_route(method):
    errors, steers, status = drive(method)
    assert status == COMPLETED
    rms, worst = BOUNDS_M[method]
    assert math.sqrt(np.mean(errors**2)) < rms
    assert np.abs(errors).max() < worst
    power = np.abs(np.fft.rfft(steers - steers.mean())) ** 2
    assert power[np.fft.rfftfreq(len(steers), TICK_S) > 1.0].sum() < 0.01 * power.sum(), (
        "the steering oscillates"
    )


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("y", "degrees"), [(2.0, 0.0), (-2.0, -30.0), (1.0, 30.0)])
def test_joins_the_route_from_beside(method, y, degrees):
    errors, _, _ = drive(method, y, math.radians(degrees), longest_s=15.0)
    assert np.abs(errors).max() < abs(y) + 1.75
    assert np.abs(errors[-40:]).max() < 0.1
