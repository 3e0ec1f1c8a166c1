"""With any values in a parameter file, the car and its world work, or refuse them with an error."""

import copy
import json
import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sdc_common.configuration import node_config
from sdc_common.driving import Command, DetectedObstacle, Observation
from sdc_common.geometry.route import Route
from sdc_common.validation import DocumentError
from sdc_package.controller import Controller
from sdc_package.input_pairing import InputPairing
from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds
from sdc_package.local_path import ReferencePath
from sdc_package.local_planner import LocalPlanner, PlannerSettings
from sdc_package.steering.axles import Axles
from sdc_package.steering.loader import METHODS, load_steering
from sdc_package.waypoint_search import WaypointSearch
from sdc_sim.physics.ackermann import AckermannTarget
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.physics.vehicle_parameters import load_vehicle
from sdc_sim.scenario.drive_setup import DriveSetup

pytestmark = pytest.mark.slow(6)

ROUTE = np.column_stack([np.arange(0.0, 60.0), 3.0 * np.sin(np.arange(0.0, 60.0) / 9.0)])


def plan(parameters, _folder):
    planner = LocalPlanner(ROUTE, PlannerSettings.read(parameters.__getitem__))
    first = WaypointSearch(planner.route.points).first_ahead(2.0, 0.5)
    return planner.plan(first, 2.0, 0.5, 0.1, [DetectedObstacle(15.0, 3.0, 0.0, 4.0, 2.0, 0.0)])


def control(parameters, _folder):
    InputPairing(print, print, parameters["patience_s"])
    path = ReferencePath()
    path.update([(x, y, 5.0) for x, y in ROUTE[:25].tolist()])
    results = []
    for method in METHODS:
        steering = load_steering(method, parameters.get(method), Axles(**parameters["axles"]))
        controller = Controller(parameters.__getitem__, steering)
        command = controller.command(Observation(50_000_000, 2.0, 0.5, 0.1, 4.0), path)
        results += [command.throttle, command.brake, command.steer]
    return results


def filter_picture(parameters, _folder):
    thresholds = LaneFilterThresholds(**parameters["lane_filter"])
    return LaneFilter(thresholds).mask(np.full((20, 20, 3), 90, np.uint8))


def simulate(parameters, _folder):
    simulation = DriveSetup(None, ROUTE, Route(ROUTE), parameters).simulation()
    simulation.step(AckermannTarget(0.1, 0.0, 5.0))
    simulation.step(Command(0.7, 0.1))
    return list(vars(simulation.vehicle.state).values())


def drive_preset(parameters, folder):
    path = folder / "fuzz_car.yaml"
    path.write_text(json.dumps(parameters))
    vehicle = Vehicle(load_vehicle(str(path)))
    vehicle.step(Command(0.7, 0.1), 0.1)
    return list(vars(vehicle.state).values())


BUILDERS = {
    "local_planner.yaml": (plan, node_config("sdc_package", "local_planner")),
    "simple_controller.yaml": (control, node_config("sdc_package", "simple_controller")),
    "camera.yaml": (filter_picture, node_config("sdc_package", "camera")),
    "sim.yaml": (simulate, node_config("sdc_sim", "sim")),
    "tesla_model3.yaml": (drive_preset, node_config("sdc_sim", "vehicles/tesla_model3")),
}
NUMBERS = st.floats(allow_nan=True) | st.floats(-10.0, 10.0) | st.integers(-3, 300)
NUMBERS |= st.sampled_from([0, 1, -1, 1e-9, 10**400])
WORDS = st.text(max_size=5) | st.sampled_from(["1.0", "nan", "", "true"])
ANYTHING = NUMBERS | st.none() | st.booleans() | WORDS | st.lists(NUMBERS | WORDS, max_size=5)
ANYTHING |= st.dictionaries(st.text(max_size=5), NUMBERS, max_size=2)


def key_paths(parameters, before=()):
    """Yield the keys that lead to each value of a parameter file."""
    for key, value in parameters.items():
        yield (*before, key)
        if isinstance(value, dict):
            yield from key_paths(value, (*before, key))


@settings(
    max_examples=max(200, settings.default.max_examples),
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(data=st.data())
def test_fuzz_any_parameters_work_or_are_refused(data, tmp_path):
    name = data.draw(st.sampled_from(sorted(BUILDERS)))
    build, parameters = BUILDERS[name]
    parameters = copy.deepcopy(parameters)
    places = st.sampled_from(sorted(key_paths(parameters)))
    for place in data.draw(st.lists(places, min_size=1, max_size=2)):
        inner = parameters
        for key in place[:-1]:
            inner = inner[key] if isinstance(inner.get(key), dict) else {}
        inner[place[-1]] = data.draw(ANYTHING)
    try:
        result = build(parameters, tmp_path)
    except (TypeError, ValueError) as error:  # The nodes exit with this message.
        assert str(error)
        named = "fuzz_car.yaml" in str(error) or "street_scenario" in str(error)
        assert named or not isinstance(error, DocumentError)
        return
    assert all(map(math.isfinite, np.asarray(result, float).ravel())), parameters
