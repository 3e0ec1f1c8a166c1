"""The packaged town: its network and its OpenDRIVE."""

import filecmp
import os
import subprocess

import numpy as np
import pytest
from scipy.spatial import cKDTree
from test_network import largest_distances_m

from sdc_map.lane_graph import LaneGraph
from sdc_map.map_file import map_file
from sdc_map.mission import plan_mission
from sdc_map.network import edge_of
from sdc_map.network_file import load_network
from sdc_testing.street_maps import dense, needs_maps

pytestmark = needs_maps
_LORRY = 375  # points of `dense` along a lorry of 7.5 m


@pytest.fixture(scope="module", name="town")
def _town():
    return load_network("town")


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


@pytest.mark.slow(2)
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


@pytest.mark.slow(4)
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
