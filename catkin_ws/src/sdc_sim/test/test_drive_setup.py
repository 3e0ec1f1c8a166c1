"""Tests of the conditions of a drive in process."""

import os

import numpy as np
import pytest

from sdc_common.configuration import node_config
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_common.validation import DocumentError
from sdc_sim.scenario.drive_setup import drive_setup, load_simulation
from sdc_sim.scenario.packaged import folder_of

TOWN = load_waypoints(os.path.join(folder_of("route"), "waypoints.csv"))
BEND = [{"straight_m": 30}, {"left_deg": 90, "radius_m": 20, "transition_m": 5}]


def write(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    return str(path)


def test_without_scenario_and_route_the_town_is_driven_with_the_parameters_of_the_sim_node():
    setup = drive_setup()
    np.testing.assert_array_equal(setup.waypoints_m, TOWN)
    assert (setup.scenario, setup.parameters) == (None, node_config("sdc_sim", "sim"))
    assert setup.route.length_m == pytest.approx(np.hypot(*np.diff(TOWN, axis=0).T).sum(), rel=0.01)


def test_given_route_is_relative_to_the_working_directory(tmp_path, monkeypatch):
    folder = tmp_path / "here"
    folder.mkdir()
    (folder / "road.csv").write_text("x,y\n0,0\n10,0\n20,0\n")
    monkeypatch.chdir(folder)
    setup = drive_setup(write(tmp_path, "route: town"), route="road.csv")
    assert setup.route.length_m == pytest.approx(20.0)


def test_route_can_be_an_array_or_straights_and_bends():
    points = np.array([[0.0, 0.0], [10.0, 0.0], [25.0, 0.0]])
    np.testing.assert_array_equal(drive_setup(route=points).waypoints_m, points)
    waypoints_m = drive_setup(route=BEND).waypoints_m
    assert (waypoints_m[0].tolist(), waypoints_m[-1][1] > 20.0) == ([0.0, 0.0], True)


def test_route_of_another_kind_is_refused():
    with pytest.raises(DocumentError, match="^route: must be the name .* straights and bends$"):
        drive_setup(route=[(0.0, 0.0), (1.0, 0.0)])


def test_simulation_has_the_obstacles_and_the_start_of_its_scenario(tmp_path):
    text = "route: [straight_m: 100]\nstart: {along_m: 20}\nframe: route\n"
    text += "obstacles: [{kind: car, at: [50, 0]}]"
    simulation = load_simulation(write(tmp_path, text))
    assert len(simulation.obstacles.states) == 1
    assert simulation.snapshot.state.x_m == pytest.approx(20.0)
    assert len(load_simulation(route=BEND).obstacles.states) == 0


def test_simulation_of_a_route_alone_has_the_given_options():
    simulation = load_simulation(route=BEND, options={"start": {"along_m": 5.0}})
    state = simulation.snapshot.state
    assert (state.x_m, state.y_m) == (pytest.approx(5.0), pytest.approx(0.0))


@pytest.mark.parametrize(
    ("name", "goal_m", "has_others"),
    [("town_roundabout", (0.0, 3.5), False), ("town_traffic", (286.0, 109.0), True)],
)
def test_scenario_of_a_map_is_loaded_with_its_map_and_traffic(name, goal_m, has_others):
    setup = drive_setup(name)
    simulation = setup.simulation()
    state = simulation.snapshot.state
    np.testing.assert_allclose(setup.waypoints_m[-1], goal_m, atol=2.0)
    np.testing.assert_allclose((state.x_m, state.y_m), setup.waypoints_m[0], atol=0.1)
    assert bool(simulation.observation.obstacles) == has_others


def test_given_map_start_and_goal_have_precedence():
    setup = drive_setup("town_roundabout", map="town_left", goal=(100.88, -4.84))
    np.testing.assert_allclose(setup.waypoints_m[-1], (100.88, -4.84), atol=2.0)
