"""The packaged town in the world: the packaged route, lines, views, OpenDRIVE and scenery."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sdc_common.geometry.road_line import road_line
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_map.lane_graph import LaneGraph
from sdc_map.map_file import map_file
from sdc_map.mission import plan_mission
from sdc_map.network_file import load_network
from sdc_sim.physics.collision import Rectangle
from sdc_sim.road import lane_invasion
from sdc_sim.road.network_markings import NetworkInvasionDetector, world_markings
from sdc_sim.road.opendrive import opendrive_file
from sdc_sim.road.scenery import SIGN
from sdc_sim.scenario.configuration import part_of_map
from sdc_sim.scenario.map_drive import first_mission
from sdc_sim.scenario.packaged import find_route
from sdc_sim.traffic.lights import lights_of
from sdc_testing.street_maps import dense, needs_maps

pytestmark = needs_maps
_ROUTE_M = road_line(load_waypoints(find_route("", "town")))


@pytest.fixture(scope="module", name="town")
def _town():
    return load_network("town")


def test_packaged_route_is_a_way_through_the_town(town):
    goals = _ROUTE_M[[100, 250, 335, 500, 650, 850, -1]]
    mission = plan_mission(LaneGraph(town), goals, *_ROUTE_M[0], 0.0)
    length_m = np.hypot(*np.diff(_ROUTE_M, axis=0).T).sum()
    assert mission.ends_m[-1] == pytest.approx(length_m, abs=0.5)
    assert cKDTree(dense(mission.points_m)).query(_ROUTE_M)[0].max() < 0.05


def test_car_that_changes_lanes_in_the_town_crosses_lines_by_their_kinds(town):
    """The avenue has two lanes each way: broken between them, solid in the middle of the road."""
    right, left = town.lanes["avenue_n_1"], town.lanes["avenue_n_2"]
    detector = NetworkInvasionDetector(town)
    crossed = []
    for share in np.linspace(0.0, 1.0, 60):
        across = left.at(np.array([40.0]))[0] - right.at(np.array([40.0]))[0]
        place = right.at(np.array([10.0 + 50.0 * share]))[0] + 2.0 * share * across
        yaw = right.heading_at(20.0) + 0.1
        crossed += detector.update(Rectangle(*place, yaw, 4.7, 2.0))
    assert crossed == [lane_invasion.BROKEN, lane_invasion.SOLID]


def test_views_show_lines_and_asphalt_of_the_whole_town(town):
    markings = world_markings(_ROUTE_M, "town")
    for shapes in (markings.edges, markings.dashes, markings.surface):
        low, high = shapes.min(axis=(0, 1)), shapes.max(axis=(0, 1))
        assert (low < (-150.0, -295.0)).all() and (high > (750.0, 330.0)).all()
    alone = world_markings(_ROUTE_M, "")
    assert alone.surface.max(axis=(0, 1))[0] < 500.0


def test_clients_of_the_bridge_get_the_opendrive_of_the_map(tmp_path):
    path = map_file("town")
    text = opendrive_file(path)
    assert text.startswith("<?xml") and "<OpenDRIVE>" in text
    assert text == opendrive_file(path.replace(".net.xml", ".xodr"))
    other = tmp_path / "TOWN.XODR"
    for encoding in ("UTF-16", "UTF-8"):  # that the file declares
        other.write_text(f'<?xml version="1.0" encoding="{encoding}"?><OpenDRIVE/>', "utf-16")
        assert opendrive_file(str(other)) == "<OpenDRIVE />"
    assert opendrive_file("/none/area.net.xml") == opendrive_file("route.csv") == ""


@pytest.mark.parametrize(("name", "side"), [("town", -1.0), ("town_left", 1.0)])
def test_signs_and_lights_are_on_the_side_of_the_traffic(name, side):
    network, scenery = load_network(name), part_of_map("road.network_scenery", name)
    signs = scenery.kind == SIGN
    assert signs.sum() > 20
    # A sign faces those that come; beside a ramp, another lane may be as near.
    poses = zip(*scenery.position_m[signs].T, scenery.yaw_rad[signs] + np.pi)
    places_m = np.array([network.nearest(*pose).cross_track_m for pose in poses])
    assert np.mean(side * places_m > 2.0) > 0.95
    for light in lights_of(network):
        x, y = light.pole_m
        to_left_m = (y - light.y_m) * np.cos(light.heading_rad)
        to_left_m -= (x - light.x_m) * np.sin(light.heading_rad)
        assert side * to_left_m > 2.0


def test_first_mission_draws_what_is_not_given(town):
    graph = LaneGraph(town)
    one, same = (first_mission(graph, None, [], 5)[0] for _ in range(2))
    assert np.array_equal(one.points_m, same.points_m)
    start, goal = map(tuple, _ROUTE_M[[0, 100]])
    mission, goals = first_mission(graph, start, [goal], 5)
    assert np.hypot(*(mission.points_m[0] - start)) < 0.05
    assert goals == [goal]
