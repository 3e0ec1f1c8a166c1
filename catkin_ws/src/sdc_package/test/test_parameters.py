"""Whatever stands in a parameter file: the car and its world are built and work, or the mistake is refused before the car moves."""

import copy
import json
import math
import os

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sdc_common.planning.speed_profile import SpeedLimits
from sdc_common.validation import check_between, check_positive
from sdc_package.actuation import PedalMap, SteeringMap
from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds
from sdc_package.local_path import ReferencePath
from sdc_package.local_planner import LocalPlanner
from sdc_package.obstacles import DetectedObstacle, ObstacleMargins
from sdc_package.pid import PidGains
from sdc_package.speed_control import SpeedControl, SpeedControlLimits
from sdc_package.steering.axles import Axles
from sdc_package.steering.method import METHODS, load_steering
from sdc_package.waypoint_search import WaypointSearch
from sdc_sim.physics.ackermann import AckermannControl, AckermannGains, AckermannTarget
from sdc_sim.physics.vehicle import Vehicle, VehicleCommand, VehicleError, load_vehicle
from sdc_sim.simulation.sensors import OdometryNoise
from sdc_sim.simulation.simulation import Simulation

SRC = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
ROAD = np.column_stack([np.arange(0.0, 60.0), 3.0 * np.sin(np.arange(0.0, 60.0) / 9.0)])


def config(*path):
    with open(os.path.join(SRC, *path), encoding="utf-8") as file:
        return yaml.safe_load(file)


PLANNER, CONTROLLER = (
    config("sdc_package", "config", "local_planner.yaml"),
    config("sdc_package", "config", "simple_controller.yaml"),
)
CAMERA, SIM = (
    config("sdc_package", "config", "camera.yaml"),
    config("sdc_sim", "config", "sim.yaml"),
)
TESLA = config("sdc_sim", "config", "vehicles", "tesla_model3.yaml")


def plan(figures, _folder):
    limits = SpeedLimits(
        figures["planned_speed_mps"],
        figures["lateral_acceleration_mps2"],
        figures["acceleration_mps2"],
        figures["braking_mps2"],
        figures["lateral_jerk_mps3"],
    )
    planner = LocalPlanner(
        ROAD,
        limits,
        figures["lookahead_m"],
        figures["join_within_m"],
        ObstacleMargins(**figures["caution"]),
    )
    first = WaypointSearch(planner.route.points).first_ahead(2.0, 0.5)
    return planner.plan(first, 2.0, 0.5, 0.1, [DetectedObstacle(15.0, 3.0, 0.0, 4.0, 2.0, 0.0)])


def control(figures, _folder):
    check_between(
        0.0, 1.0, basic_throttle=figures["basic_throttle"], stop_brake=figures["stop_brake"]
    )
    check_positive(patience_s=figures["patience_s"])
    speed_control = SpeedControl(
        PidGains(**figures["pid"]), SpeedControlLimits(**figures["limits"])
    )
    steering_map, pedals, road = (
        SteeringMap(**figures["steering"]),
        PedalMap(**figures["pedals"]),
        ReferencePath(),
    )
    road.update([(x, y, 5.0) for x, y in ROAD[:25].tolist()])
    results = []
    for method in METHODS:
        steering = load_steering(method, figures.get(method), Axles(**figures["axles"]))
        target = road.nearest(2.0, 0.5, speed_control.preview_m(4.0))
        results += pedals.pedals(
            speed_control.acceleration(target.speed_mps, target.acceleration_mps2, 4.0, 0.05)
        )
        results.append(steering_map.command(steering.wheel_angle(road, 2.0, 0.5, 0.1, 4.0), 4.0)[0])
    return results


def look(figures, _folder):
    return LaneFilter(LaneFilterThresholds(**figures["lane_filter"])).mask(
        np.full((20, 20, 3), 90, np.uint8)
    )


def world(figures, _folder):
    vehicle = Vehicle(
        load_vehicle(os.path.join(SRC, "sdc_sim", "config", "vehicles", "tesla_model3.yaml")),
        friction=figures["friction"],
        side_wind_mps=figures["side_wind_mps"],
    )
    here = Simulation(
        vehicle,
        figures["tick_s"],
        figures["command_patience_s"],
        noise=OdometryNoise(figures["seed"], **figures["odometry_noise"]),
        ackermann=AckermannControl(vehicle.parameters, AckermannGains(**figures["ackermann"])),
        command_latency_s=figures["command_latency_s"],
        sensor_latency_s=figures["sensor_latency_s"],
    )
    return moved(here)


def moved(here):
    here.obey_ackermann(AckermannTarget(0.1, 0.0, 5.0))
    here.advance()
    here.obey(VehicleCommand(0.7, 0.1))
    here.advance()
    return [value for value in vars(here.vehicle.state).values()]


def car(figures, folder):
    path = folder / "fuzz_car.yaml"
    path.write_text(json.dumps(figures))
    vehicle = Vehicle(load_vehicle(str(path)))
    vehicle.step(VehicleCommand(0.7, 0.1), 0.1)
    return list(vars(vehicle.state).values())


BUILDERS = {
    "local_planner.yaml": (plan, PLANNER),
    "simple_controller.yaml": (control, CONTROLLER),
    "camera.yaml": (look, CAMERA),
    "sim.yaml": (world, SIM),
    "tesla_model3.yaml": (car, TESLA),
}
NUMBERS = st.one_of(
    st.floats(allow_nan=True),
    st.floats(-10.0, 10.0),
    st.integers(-3, 300),
    st.sampled_from([0, 1, -1, 1e-9, 10**400]),
)
WORDS = st.text(max_size=5) | st.sampled_from(["1.0", "nan", "", "true"])
ANYTHING = st.one_of(
    NUMBERS,
    st.none(),
    st.booleans(),
    WORDS,
    st.lists(NUMBERS | WORDS, max_size=5),
    st.dictionaries(st.text(max_size=5), NUMBERS, max_size=2),
)


def places(figures, before=()):
    """Every line of a parameter file, as the keys that lead to it."""
    for key, value in figures.items():
        yield (*before, key)
        if isinstance(value, dict):
            yield from places(value, (*before, key))


@pytest.mark.parametrize("name", BUILDERS)
def test_the_files_as_they_are_work(name, tmp_path):
    build, figures = BUILDERS[name]
    assert np.isfinite(np.asarray(build(copy.deepcopy(figures), tmp_path), float)).all()


@settings(
    max_examples=max(500, settings.default.max_examples),
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(data=st.data())
def test_fuzz_any_parameters_work_or_are_refused(data, tmp_path):
    name = data.draw(st.sampled_from(sorted(BUILDERS)))
    build, figures = BUILDERS[name]
    figures = copy.deepcopy(figures)
    for place in data.draw(
        st.lists(st.sampled_from(sorted(places(figures))), min_size=1, max_size=2)
    ):
        inner = figures
        for key in place[:-1]:
            inner = (
                inner[key] if isinstance(inner, dict) and isinstance(inner.get(key), dict) else {}
            )
        inner[place[-1]] = data.draw(ANYTHING)
    try:
        result = build(figures, tmp_path)
    except (TypeError, ValueError) as error:  # what the nodes turn into one line and exit code 1
        assert str(error)
        assert (
            not isinstance(error, VehicleError)
            or "fuzz_car.yaml" in str(error)
            or "internal_step_s" in str(error)
        )
        return
    assert all(map(math.isfinite, np.asarray(result, float).ravel())), figures
