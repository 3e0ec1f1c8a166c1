"""The packaged town: its network, its OpenDRIVE, and the packaged route through it."""

import filecmp
import os
import subprocess

import numpy as np
import pytest
from scipy.spatial import cKDTree
from street_maps import needs_maps
from test_network import dense, largest_distances_m

from sdc_common.geometry.road_line import road_line
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.physics.collision import Rectangle
from sdc_sim.road import lane_invasion
from sdc_sim.road.lane_graph import LaneGraph
from sdc_sim.road.mission import plan_mission
from sdc_sim.road.network import edge_of
from sdc_sim.road.network_file import load_network
from sdc_sim.road.network_markings import NetworkInvasionDetector, world_markings
from sdc_sim.road.opendrive import opendrive_file
from sdc_sim.road.scenery import SIGN
from sdc_sim.scenario.configuration import part_of_map
from sdc_sim.scenario.packaged import find_route
from sdc_sim.yaml_document import map_file

pytestmark = needs_maps
_LORRY = 375  # points of `dense` along a lorry of 7.5 m
_ROUTE_M = road_line(load_waypoints(find_route("", "town")))


@pytest.fixture(scope="module", name="town")
def _town():
    return load_network("town")


def test_packaged_route_is_on_lanes_of_the_town(town):
    lanes = cKDTree(np.vstack([dense(one.points_m) for one in town.driving]))
    assert lanes.query(dense(_ROUTE_M))[0].max() < 0.05


def test_packaged_route_is_a_way_through_the_town(town):
    goals = _ROUTE_M[[100, 250, 335, 500, 650, 850, -1]]
    mission = plan_mission(LaneGraph(town), goals, *_ROUTE_M[0], 0.0)
    length_m = np.hypot(*np.diff(_ROUTE_M, axis=0).T).sum()
    assert mission.ends_m[-1] == pytest.approx(length_m, abs=0.5)
    assert cKDTree(dense(mission.points_m)).query(_ROUTE_M)[0].max() < 0.05


def test_two_changes_of_lanes_are_on_two_stretches(town):
    start, goal = (town.lanes[name].at(np.array([50.0]))[0] for name in ("-land_e_0", "ramp_off_0"))
    lanes = plan_mission(LaneGraph(town), [goal], *start).lanes
    outside = [name for name in lanes if not town.lanes[name].junction]
    assert outside == ["-land_e_0", "m_w1_1", "m_w1_0", "m_w2_1", "m_w2_0", "ramp_off_0"]


def test_town_has_all_kinds_of_junctions_and_streets(town):
    junctions = [one for one in town.junctions.values() if len(one.connections) > 2]
    kinds = {one.kind for one in junctions}
    assert len(junctions) >= 12 and len(town.crosswalks) >= 8
    assert kinds >= {"traffic_light", "priority", "right_before_left", "priority_stop"}
    limits_kmh = {round(3.6 * lane.speed_limit_mps) for lane in town.driving if not lane.junction}
    assert limits_kmh >= {20, 30, 50, 60, 100, 130}
    assert town.lanes["avenue_n_1"].left == "avenue_n_2"


def test_ways_that_no_one_yields_on_are_apart(town):
    for junction in town.junctions.values():
        points = [
            np.vstack([dense(town.lanes[name].points_m) for name in one.through])
            for one in junction.connections
        ]
        # A lorry cuts the bends with its middle.
        bodies = [np.vstack([way, 0.5 * (way[:-_LORRY] + way[_LORRY:])]) for way in points]
        for i, one in enumerate(junction.connections):
            for j, other in enumerate(junction.connections[:i]):
                meets = j in one.gives_way_to or i in other.gives_way_to
                beside = edge_of(one.start) == edge_of(other.start)
                if not (meets or beside or edge_of(one.end) == edge_of(other.end)):
                    pairs = (bodies[i], points[j]), (bodies[j], points[i])
                    apart_m = min(cKDTree(body).query(way)[0].min() for body, way in pairs)
                    assert apart_m > 2.5, (junction.id, one.start, other.start)


def test_bays_are_beside_lanes_and_bus_stops_on_them(town):
    assert len(town.bays) == 38 and len(town.bus_stops) == 2
    for area in town.bays:
        place = town.nearest(*area.mean(axis=0))
        assert -5.0 < place.cross_track_m < -0.5 * town.lanes[place.lane].width_m
    for area in town.bus_stops:
        place = town.nearest(*area.mean(axis=0))
        assert place.lane.endswith("high_b_1") and -1.75 < place.cross_track_m < 0.0


def test_opendrive_of_the_town_has_the_same_lanes_outside_junctions(town):
    path = map_file("town").replace(".net.xml", ".xodr")
    outside_m, inside_m, _ = largest_distances_m(path)
    assert (outside_m <= 0.05, inside_m <= 0.2) == (True, True)
    lines = [dense(one.points_m) for one in load_network(path).driving]
    streets = [dense(one.points_m) for one in town.driving if not one.junction]
    distances = cKDTree(np.vstack(lines)).query(np.vstack(streets))[0]
    assert np.mean(distances < 0.05) > 0.995


def test_network_and_opendrive_are_made_of_the_files_that_people_edit(tmp_path):
    folder = os.path.dirname(map_file("town"))
    done = subprocess.run([folder + "/make_town", tmp_path], capture_output=True, check=False)
    if done.returncode == 127:
        pytest.skip("netconvert is not installed")
    for name in ("town.net.xml", "town.xodr"):
        assert filecmp.cmp(tmp_path / name, os.path.join(folder, name), shallow=False)


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


def test_clients_of_the_bridge_get_the_opendrive_of_the_map():
    path = map_file("town")
    text = opendrive_file(path)
    assert text.startswith("<?xml") and "<OpenDRIVE>" in text
    assert text == opendrive_file(path.replace(".net.xml", ".xodr"))
    assert opendrive_file("/none/area.net.xml") == opendrive_file("route.csv") == ""


def test_lidars_see_the_scenery_of_the_map():
    suite_scenery = part_of_map("road.network_scenery", "town")
    assert (suite_scenery.kind == SIGN).any()
    assert part_of_map("road.network_scenery", "") == ()
