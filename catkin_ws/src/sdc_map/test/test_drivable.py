"""Routes over maps are lines that a car can drive: no fold, no jump, no bend that is too tight."""

import glob
import os

import numpy as np
import pytest

from sdc_common.geometry.road_line import arc_lengths, sharpest_turn
from sdc_map.drivable import LEAST_RADIUS_M, without_bends
from sdc_map.findings import Findings
from sdc_map.lane_graph import LaneGraph, drawn_places
from sdc_map.mission import plan_mission
from sdc_map.network import Network, RoadLane
from sdc_map.network_file import load_network
from sdc_testing.street_maps import lane, needs_maps, opendrive, town, write

_OTHERS = sorted(glob.glob(os.environ.get("SDC_MAPS", "") + "/*.xodr")) + sorted(
    glob.glob(os.environ.get("SDC_MAPS", "") + "/*.net.xml")
)


def greatest_fold_m(points):
    """Return how far a line goes back against its direction before, within 5 steps [m]."""
    steps = np.diff(points, axis=0)
    steps /= np.hypot(*steps.T)[:, None]
    folds = [0.0]
    for row, direction in enumerate(steps):
        along = (points[row : row + 6] - points[row]) @ direction
        folds.append(float((np.maximum.accumulate(along) - along).max()))
    return max(folds)


def assert_drivable(points):
    """Raise AssertionError for a line that a car cannot drive."""
    assert greatest_fold_m(points) <= 0.5
    assert sharpest_turn(points)[0] <= 2.0 / LEAST_RADIUS_M
    assert np.hypot(*np.diff(points, axis=0).T).max() <= 1.3


def assert_routes_are_drivable(network, count):
    """Draw routes over a network, and raise AssertionError for one that a car cannot drive."""
    graph = LaneGraph(network)
    for seed in range(count):
        start, goal = drawn_places(graph, seed)
        mission = plan_mission(graph, [goal], *start)
        assert_drivable(mission.points_m)
        way = [network.lanes[name] for name in mission.lanes]
        for one, other in zip(way, way[1:]):
            if other.id in one.successors:
                assert np.hypot(*(other.points_m[0] - one.points_m[-1])) <= 0.3


_PIECE = '<geometry s="{}" x="{}" y="{}" hdg="{}" length="{}"><line/></geometry>'


def corner_road():
    """Return a road with a reference line of straight pieces around a bend, and wide lanes."""
    text = opendrive("<line/>", 316, lane(-1, (6.0, 0.0)), lane(1, (6.0, 0.0)))
    begin, end = text.index("<geometry"), text.index("</planView>")
    s, place, pieces = 0.0, np.zeros(2), ""
    for length, heading in ((150, 0.0), (4, 0.3), (4, 0.7), (4, 1.0), (4, 1.4), (150, 1.5)):
        pieces += _PIECE.format(s, *place, heading, length)
        s, place = s + length, place + length * np.array([np.cos(heading), np.sin(heading)])
    return text[:begin] + pieces + text[end:]


_MAPS = {
    "town": lambda folder: "town",
    "network": town,
    "network with turnarounds": lambda folder: town(folder, turns="--no-internal-links=false"),
    "OpenDRIVE": lambda folder: town(folder, "--opendrive-output", "town.xodr"),
    "corner": lambda folder: write(folder, corner_road()),
}


@needs_maps
@pytest.mark.slow(5)
@pytest.mark.parametrize("name", _MAPS)
def test_drawn_routes_are_drivable(tmp_path, name):
    assert_routes_are_drivable(load_network(_MAPS[name](tmp_path)), 100)


@needs_maps
@pytest.mark.nightly
@pytest.mark.parametrize("path", _OTHERS)
def test_drawn_routes_of_other_maps_are_drivable(path):
    assert_routes_are_drivable(load_network(path), 100)


@needs_maps
def test_connections_that_no_car_can_drive_are_left_out(tmp_path):
    network = load_network(town(tmp_path, turns="--no-internal-links=false"))
    (text,) = network.findings.lines()
    assert text.startswith("bends that no car can drive (")
    turns = [c for junction in network.junctions.values() for c in junction.connections]
    turns = [one for one in turns if one.direction == "t"]
    assert turns
    for one in turns:
        assert one.through[0] not in network.lanes[one.start].successors


def lanes_of(lines, leads):
    """Return lanes by their lines, those in junctions begin with ":", and where each leads."""
    return [
        RoadLane(
            name,
            np.array(line, float),
            3.5,
            10.0,
            predecessors=tuple(before for before in lines if name in leads.get(before, ())),
            successors=leads.get(name, ()),
            junction=name[1:2] if name.startswith(":") else "",
        )
        for name, line in lines.items()
    ]


def test_connection_behind_a_fold_is_left_out_though_the_fold_begins_before_it():
    lines = {
        "north": [(-2, 80), (-2, 38)],
        ":a_0": [(-2, 38), (-3, 8), (-4, -1), (-5, -6)],
        "short": [(-5, -6), (-1.5, 0), (-3, -1), (-4, -2.5)],
        ":b_0": [(-4, -2.5), (-6.5, -1)],
        "west": [(-6.5, -1), (-50, -1)],
    }
    names = list(lines)
    lanes = lanes_of(lines, {name: (after,) for name, after in zip(names, names[1:])})
    known = {lane.id: lane for lane in without_bends(lanes, Findings())}
    assert known["short"].successors == ()


def test_mission_avoids_a_bend_that_no_car_can_drive_where_another_way_exists():
    angles = np.linspace(-np.pi / 2, np.pi / 2, 17)
    lines = {
        "out": [(0, 0), (50, 0)],
        ":u_0": [(50, 0), (51, 1.5), (50, 3)],
        "back": [(50, 3), (0, 3)],
        ":w_0": [(50 + 20 * np.cos(a), 20 + 20 * np.sin(a)) for a in angles],
        "wide": [(50, 40), (0, 40)],
        ":e_0": [(0, 3), (-50, 20)],
        ":f_0": [(0, 40), (-50, 20)],
        "end": [(-50, 20), (-100, 20)],
    }
    leads = {"out": (":u_0", ":w_0"), ":u_0": ("back",), ":w_0": ("wide",), "back": (":e_0",)}
    leads.update({"wide": (":f_0",), ":e_0": ("end",), ":f_0": ("end",)})
    graph = LaneGraph(Network("test", lanes_of(lines, leads)))
    mission = plan_mission(graph, [(-90, 20)], 5, 0)
    assert "wide" in mission.lanes
    assert_drivable(mission.points_m)
    mission = plan_mission(graph, [(-90, 20)], 5, 0, closed={"wide"})
    assert "back" in mission.lanes, "the only way stays"


def way_over(*lines):
    """Return a mission over lanes, one after another, each with a limit of its number [m/s]."""
    lanes = [
        RoadLane(
            str(number),
            np.array(line, float),
            3.5,
            float(number),
            predecessors=(str(number - 1),) if number > 1 else (),
            successors=(str(number + 1),) if number < len(lines) else (),
        )
        for number, line in enumerate(lines, 1)
    ]
    graph = LaneGraph(Network("test", lanes))
    mission = plan_mission(graph, [lines[-1][-1]], *lines[0][0])
    assert mission.lanes == tuple(one.id for one in lanes)
    return mission


_ANGLES = np.linspace(0.0, np.pi / 2, 9)


def turn(radius_m):
    """Return two straight lanes at a right angle, and an arc between them."""
    r = radius_m
    arc = [(50 + r * np.sin(a), r - r * np.cos(a)) for a in _ANGLES]
    return [(0, 0), (50, 0)], arc, [(50 + r, r), (50 + r, 50)]


@pytest.mark.parametrize(
    ("lines", "length_m", "beside_m"),
    [
        ([[(0, 0), (50, 0)], [(50, 0), (49.8, 0)], [(46, 0), (100, 0)]], 100.0, 0.03),
        ([[(0, 0), (50, 0)], [(50, 0), (47, 0.2)], [(47, 0.2), (100, 0.2)]], 100.0, 0.11),
        ([[(0, 0), (50, 0)], [(50, 0.29), (100, 0.29)]], 100.0, 0.17),
        ([[(0, 0), (50, 0)], [(50, 0), (50, 50)]], 98.3, 1.25),
        (turn(2.0), 100.5, 0.7),
        (turn(6.0), 50.0 + 6.0 * np.pi / 2 + 44.0, 0.03),
    ],
)
def test_bends_and_folds_become_curves(lines, length_m, beside_m):
    mission = way_over(*lines)
    points = mission.points_m
    assert_drivable(points)
    assert mission.ends_m == pytest.approx((arc_lengths(points)[-1],), abs=0.1)
    assert mission.ends_m == pytest.approx((length_m,), abs=0.5)
    rows = [np.linspace(0.0, 1.0, 1001)[:, None]]
    along = np.vstack([a + rows[0] * (np.subtract(b, a)) for c in lines for a, b in zip(c, c[1:])])
    distances = [np.hypot(*(along - point).T).min() for point in points]
    assert max(distances) <= beside_m
    assert (mission.limits_mps[0], mission.limits_mps[-1]) == (1.0, float(len(lines)))
    assert (np.diff(mission.limits_mps) >= 0.0).all()
