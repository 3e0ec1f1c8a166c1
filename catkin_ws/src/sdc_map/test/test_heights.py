"""Heights of lanes: what lies over each other is apart."""

import math
import shutil

import numpy as np
import pytest

from sdc_common.geometry.route import Route
from sdc_map.crossings import heights_along, places_along
from sdc_map.lane_graph import LaneGraph
from sdc_map.mission import plan_mission
from sdc_map.network import Connection, Junction, Network, RoadLane
from sdc_map.network_file import load_network
from sdc_testing.street_maps import bridge, needs_maps

pytestmark = needs_maps
# Directions [rad].
EAST = 0.0
NORTH = 0.5 * math.pi
WEST = math.pi


@pytest.fixture(scope="module", name="path")
def _path(tmp_path_factory):
    return bridge(tmp_path_factory.mktemp("bridge"))


@pytest.fixture(scope="module", name="network", params=["OpenDRIVE", "SUMO"])
def _network(path, request, tmp_path_factory):
    if request.param == "OpenDRIVE":
        return load_network(path)
    copy = str(tmp_path_factory.mktemp("net") / "bridge.net.xml")
    return load_network(shutil.copy(load_network(path).net_path, copy))


@pytest.mark.parametrize(
    ("x", "y", "yaw", "z", "expected"),
    [
        (0.0, -1.75, EAST, 6.0, (6.0, 0.0)),
        (0.0, -1.75, EAST, 0.0, (0.0, 0.0)),  # a car that is turned on the lower street
        (1.75, 0.0, NORTH, 0.0, (0.0, 0.0)),
        (1.75, 0.0, NORTH, 6.0, (6.0, 0.0)),
        (1.75, 0.0, NORTH, math.nan, (0.0, 0.0)),
        (-110.0, -1.75, EAST, 2.0, (3.0, -math.atan(0.1))),  # the nose is up
        (-110.0, 1.75, WEST, 4.0, (3.0, math.atan(0.1))),
        (-170.0, -1.75, EAST, math.nan, (0.0, 0.0)),
    ],
)
def test_ground_is_that_of_the_level(network, x, y, yaw, z, expected):
    assert network.ground_at(x, y, yaw, z) == pytest.approx(expected, abs=0.02)


def test_lane_of_another_level_is_not_near(network):
    assert network.nearest(60.0, -1.75, EAST, 2.5, 6.0) is not None
    assert network.nearest(60.0, -1.75, EAST, 2.5, 2.0) is None


def test_way_over_the_bridge_and_below_it_has_the_height_of_each_place(network):
    mission = plan_mission(LaneGraph(network), [(-1.75, -195.0)], -195.0, -1.75)
    route = Route(mission.points_m)
    places = list(places_along(network, route))
    heights_m = heights_along(network, route, places)
    first, second = np.flatnonzero(np.hypot(*route.points.T) < 2.5)[[0, -1]]
    assert (heights_m[first], heights_m[second]) == pytest.approx((6.0, 0.0), abs=0.05)
    assert np.abs(np.diff(heights_m)).max() < 0.12


@pytest.mark.parametrize(("height_m", "count"), [(0.0, 1), (2.0, 1), (6.0, 0)])
def test_ways_of_a_junction_at_different_heights_do_not_conflict(height_m, count):
    ends = {"a": ((-30.0, 0.0), (30.0, 0.0), 0.0), "b": ((0.0, -30.0), (0.0, 30.0), height_m)}
    lanes, connections = [], []
    for number, (name, (start, end, z_m)) in enumerate(ends.items()):
        cuts = np.linspace(start, end, 4)
        for part, junction in enumerate(("", "j", "")):
            heights_m = np.full(2, z_m)
            places = cuts[part : part + 2], 3.5, 10.0
            lane = RoadLane(f"{name}{part}_0", *places, junction=junction, z_m=heights_m)
            lanes.append(lane)
        connections.append(
            Connection(f"{name}0_0", (f"{name}1_0",), f"{name}2_0", "s", (1 - number,))
        )
    network = Network("two", lanes, [Junction("j", "priority", np.zeros((1, 2)), (*connections,))])
    assert [len(network.ways[f"{name}0_0"][0].first) for name in "ab"] == [count, count]
