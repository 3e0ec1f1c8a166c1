"""Networks of lanes: reading of OpenDRIVE and of SUMO's networks, and nearest lanes."""

import glob
import gzip
import math
import os
import re
from types import SimpleNamespace

import numpy as np
import pytest
from opendrive_geometry import lane_centre_lines
from scipy.spatial import cKDTree

from sdc_common.geometry.road_line import sharpest_turn
from sdc_common.geometry.route import Route
from sdc_map import sumo_programs
from sdc_map.crossings import crossings, places_along
from sdc_map.drivable import joint
from sdc_map.lane_graph import LaneGraph, NoRouteError
from sdc_map.mission import plan_mission
from sdc_map.network import (
    BROKEN,
    DOUBLE,
    NONE,
    SOLID,
    STOP,
    WALKING,
    YIELD,
    Connection,
    Junction,
    Network,
    RoadLane,
    edge_of,
)
from sdc_map.network_file import MapError, load_network
from sdc_testing.street_maps import dense, lane, needs_maps, opendrive, town, write

pytestmark = needs_maps

_OTHERS = sorted(glob.glob(os.environ.get("SDC_MAPS", "") + "/*.xodr"))
_TWO = lane(-1, mark="broken") + lane(-2)
_SHIFT = (
    '<laneOffset s="0" a="0" b="0" c="0" d="0"/><laneOffset s="9" a="0" b=".04" c=".001" d="0"/>'
)
_PROJECTION = '<geoReference>+proj=tmerc +lat_0=49</geoReference><offset x="500" y="9"/>'
_PARAM = '<paramPoly3 pRange="{}" aU="0" bU="{}" cU="0" dU="0" aV="0" bV="0" cV="{}" dV="0"/>'
_MAPS = {
    "line": opendrive("<line/>", 80, _TWO, lane(1)),
    "arc": opendrive('<arc curvature="0.05"/>', 30, _TWO, lane(1) + lane(2)),
    "spiral": opendrive('<spiral curvStart="0" curvEnd="-0.08"/>', 30, _TWO, lane(1)),
    "poly3": opendrive('<poly3 a="0" b="0" c="0.004" d="5e-5"/>', 40, _TWO, lane(1)),
    "paramPoly3": opendrive(_PARAM.format("arcLength", 1, 0.002), 40, _TWO, lane(1)),
    "normalized": opendrive(_PARAM.format("normalized", 40, 3.2), 40, _TWO, lane(1)),
    "offset": opendrive("<line/>", 80, _TWO, lane(1), _SHIFT, _PROJECTION),
    "wider": opendrive('<arc curvature="0.03"/>', 60, lane(-1, (3, 0.02)) + lane(-2), lane(1)),
    "median": opendrive("<line/>", 50, lane(-1, kind="median") + _TWO.replace("-1", "-3"), lane(1)),
}


_TWICE = _MAPS["line"].replace("</OpenDRIVE>", _MAPS["line"].partition("</header>")[2])


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / "cache"))


@pytest.fixture(scope="module", name="streets")
def _streets(tmp_path_factory):
    return load_network(town(tmp_path_factory.mktemp("town")))


def largest_distances_m(path):
    """Return the greatest distance of a lane from those of OpenDRIVE, outside junctions and inside.

    And the greatest distance of a lane of OpenDRIVE from those of the network.
    """
    lines, network = lane_centre_lines(path), load_network(path)
    exact = cKDTree(np.vstack([dense(line) for line in lines]))
    own = cKDTree(np.vstack([dense(one.points_m) for one in network.driving]))
    outside, inside = [0.0], [0.0]
    for one in network.driving:
        distances = exact.query(dense(one.points_m))[0]
        (inside if one.junction else outside).append(distances.max())
    return max(outside), max(inside), own.query(np.vstack(lines))[0].max()


@pytest.mark.slow(2)
@pytest.mark.parametrize("name", _MAPS)
def test_centre_lines_are_those_of_an_independent_reader(name, tmp_path):
    outside_m, _, _ = largest_distances_m(write(tmp_path, _MAPS[name]))
    assert outside_m <= 0.05


@pytest.mark.parametrize("path", ["", *_OTHERS], ids=os.path.basename)
def test_maps_with_junctions_are_within_5_and_20_cm(tmp_path, path):
    """The first map is a town of streets, the others are those of the folder SDC_MAPS."""
    path = path or town(tmp_path, "--opendrive-output", "town.xodr")
    outside_m, inside_m, uncovered_m = largest_distances_m(path)
    assert (outside_m <= 0.05, inside_m <= 0.2, uncovered_m <= 0.3) == (True, True, True)


def chain(*lengths):
    """Return a map of straight roads 1, 2, ... of these lengths to the east, one after another.

    Long ones have a wide lane on the right.
    """
    roads, start = "", 0.0
    for number, length in enumerate(lengths, 1):
        links = [("predecessor", number - 1, "end"), ("successor", number + 1, "start")]
        text = "".join(
            f'<{way} elementType="road" elementId="{other}" contactPoint="{contact}"/>'
            for way, other, contact in links
            if 1 <= other <= len(lengths)
        )
        wide = lane(-2, (7.0, 0.0)) if length > 10.0 else ""
        road = opendrive("<line/>", length, linked(-1) + wide, linked(1)).partition("<road")[2]
        road = road.replace('id="7"', f'id="{number}"').replace(
            "<link/>", f"<link>{text}</link>", 1
        )
        roads += "<road" + road.replace('x="10"', f'x="{start}"').replace('hdg="0.3"', 'hdg="0"')
        roads = roads.replace("</OpenDRIVE>", "")
        start += length
    return f'<OpenDRIVE><header revMajor="1" revMinor="4"/>{roads}</OpenDRIVE>'


def linked(number):
    """Return a lane that goes on with the same number."""
    link = f'<link><predecessor id="{number}"/><successor id="{number}"/></link>'
    return lane(number).replace("<width", link + "<width")


def test_way_over_short_roads_has_their_length_and_does_not_fold_back(tmp_path):
    # netconvert's junctions are larger than these roads between others that are wider.
    lengths = (60.0, 1.0, 0.4, 60.0)
    network = load_network(write(tmp_path, chain(*lengths)))
    mission = plan_mission(LaneGraph(network), [(sum(lengths), -5.75)], 0.0, -5.75)
    assert mission.ends_m == pytest.approx((sum(lengths),), abs=0.05)
    assert np.diff(mission.points_m[:, 0]).min() > 0.9
    assert mission.points_m[:, 1] == pytest.approx(-5.75, abs=0.01)


def test_lane_over_sections_of_other_numbers_is_followed(tmp_path):
    # Lane -1 becomes lane -2 where a lane begins on its left, which grows to 3 m within 20 m.
    begins = lane(-1, (0.0, 0.15))
    right = begins + linked(-2).replace('predecessor id="-2"', 'predecessor id="-1"')
    first = linked(-1).replace('successor id="-1"', 'successor id="-2"')
    text = opendrive("<line/>", 60, first).replace("</laneSection>", "</laneSection>{}")
    text = text.format(
        f'<laneSection s="40"><center>{lane(0)}</center><right>{right}</right></laneSection>'
    )
    # The limit changes in both sections, which divides each of them.
    types = "".join(f'<type s="{s}"><speed max="9"/></type><type s="{s + 5}"/>' for s in (10, 48))
    path = write(tmp_path, text.replace("</type>", "</type>" + types, 1))
    lines = np.vstack([dense(line) for line in lane_centre_lines(path)])
    network = load_network(path)
    left = np.array([-math.sin(0.3), math.cos(0.3)])
    goal = np.array([10.0, -4.0]) + 59.0 * np.array([left[1], -left[0]]) - 4.6 * left
    mission = plan_mission(LaneGraph(network), [goal], 11.0, -5.5)
    assert cKDTree(lines).query(mission.points_m)[0].max() < 0.05


def test_line_between_lanes_that_loops_is_replaced():
    before, after = np.array([[0.0, 0.0], [20.0, 0.0]]), np.array([[30.0, 1.0], [50.0, 1.0]])
    good = np.array([[20.2, 0.1], [25.0, 0.5], [30.2, 1.0]])
    loop = np.array([[20.0, 0.0], [26.0, 0.0], [24.0, 3.0], [22.0, 0.0], [30.0, 1.0]])
    assert joint(before, after, [loop, good])[1] == pytest.approx([24.9, 0.45], abs=0.1)
    for line in (loop, before[1:].repeat(2, axis=0)):  # the second one has no length
        curve = joint(before, after, [line])
        assert (curve[0], curve[-1]) == (pytest.approx([20.0, 0.0]), pytest.approx([30.0, 1.0]))
        assert np.degrees(sharpest_turn(np.vstack([before, curve, after]))[0]) < 10.0


def test_lanes_of_one_edge_that_are_not_beside_one_another_are_no_neighbours(tmp_path):
    with open(town(tmp_path), encoding="utf-8") as file:
        text = re.sub(r'(id="a_2" [^>]*shape=)"[^"]*"', r'\1"-120.0,40.0 -8.0,0.0"', file.read())
    network = load_network(write(tmp_path, text, "apart.net.xml"))
    assert (network.lanes["a_1"].left, network.lanes["a_2"].right) == ("", "")


def meeting_road(number, place, way, right, left=""):
    """Return a straight road of 100 m from (x, y, heading), whose `way` is junction 9."""
    text = opendrive("<line/>", 100, right, left).partition("<road")[2].partition("</Open")[0]
    x, y, heading = place
    link = f'<link><{way} elementType="junction" elementId="9"/></link>'
    text = text.replace("<link/>", link, 1).replace('id="7"', f'id="{number}"')
    return "<road" + text.replace('x="10" y="-4" hdg="0.3"', f'x="{x}" y="{y}" hdg="{heading}"')


def direct(roads, *connections):
    """Return a map of roads with a direct junction: (incoming, linked, contact, lane links)."""
    rows = "".join(
        f'<connection id="{number}" incomingRoad="{one}" linkedRoad="{other}" contactPoint="{end}">'
        + "".join(f'<laneLink from="{a}" to="{b}"/>' for a, b in links)
        + "</connection>"
        for number, (one, other, end, links) in enumerate(connections)
    )
    junction = f'<junction id="9" name="" type="direct">{rows}</junction>'
    return f'<OpenDRIVE><header revMajor="1" revMinor="7"/>{"".join(roads)}{junction}</OpenDRIVE>'


_THREE = lane(-1, mark="broken") + lane(-2) + lane(-3)
_LEFT = lane(1, mark="broken") + lane(2) + lane(3)
_BEFORE = meeting_road(1, (0, 0, 0), "successor", _THREE, lane(1) + lane(2))
_AFTER = meeting_road(2, (100, 0, 0), "predecessor", _TWO, lane(1))
_RAMP = meeting_road(3, (100, -7, 0), "predecessor", lane(-1))
_ALONG = [(-1, -1), (-2, -2), (1, 1)]
_LINKS = (1, 2, "start", [*_ALONG, (-9, -9)]), (1, 3, "start", [(-3, -1)])
_DIRECT = {
    "exit": direct([_BEFORE, _AFTER, _RAMP], *_LINKS),
    "exit, linked from the other side": direct(
        [_BEFORE, _AFTER, meeting_road(3, (200, -7, math.pi), "successor", "", lane(1))],
        (2, 1, "end", _ALONG),
        (3, 1, "", [(1, -3)]),
    ),
    # Its left lanes are not in the order of their numbers.
    "exit of a road that begins there": direct(
        [meeting_road(1, (100, 0, math.pi), "predecessor", lane(-1), _LEFT), _AFTER, _RAMP],
        (1, 2, "start", [(1, -1), (2, -2), (-1, 1)]),
        (1, 3, "start", [(3, -1)]),
    ),
    "entry": direct(
        [
            meeting_road(1, (100, 0, 0), "predecessor", _THREE, lane(1)),
            meeting_road(2, (0, 0, 0), "successor", _TWO, lane(1)),
            meeting_road(3, (0, -7, 0), "successor", lane(-1)),
        ],
        (2, 1, "start", _ALONG),
        (3, 1, "start", [(-1, -3)]),
    ),
}


@pytest.mark.parametrize("name", _DIRECT)
def test_lanes_lead_on_over_a_direct_junction(tmp_path, name):
    network = load_network(write(tmp_path, _DIRECT[name]))
    graph = LaneGraph(network)
    for y, start, end in ((-1.75, 20, 180), (-5.25, 20, 180), (-8.75, 20, 180), (1.75, 180, 20)):
        mission = plan_mission(graph, [(end, y)], start, y, 0.0 if start < end else math.pi)
        assert mission.ends_m == pytest.approx((160.0,), abs=1e-3)
        assert mission.points_m[:, 1] == pytest.approx(y, abs=1e-3)
    # No lane leads to those that are not linked: the ramp, and an outer one of the other direction.
    for goal, start in (((180, -8.75), (20, -5.25, 0.0)), ((20, 5.25), (180, 1.75, math.pi))):
        if name.startswith("exit") and network.nearest(*goal, within_m=1.0):
            with pytest.raises(NoRouteError):
                plan_mission(graph, [goal], *start)
    unlinked = (
        "links of direct junctions between other lanes (1, the first: junction 9, lane -9 to -9)"
    )
    assert [*network.findings.lines()] == ([unlinked] if name == "exit" else [])


@pytest.mark.parametrize("length_m", [0.0, 1e-12])
def test_way_without_length_meets_another_one(length_m):
    # As netconvert makes of a direct junction.
    lines = {
        "a0": [(-30, 0), (-4, 0)],
        "a1": [(-4, 0), (4, 0)],
        "a2": [(4, 0), (30, 0)],
        "b0": [(-30, -8), (3, -1)],
        "b1": [(4, -1), (4, -1 + length_m)],
    }
    lanes = [
        RoadLane(f"{name}_0", np.array(line, float), 3.5, 10.0, junction="j" * name.endswith("1"))
        for name, line in lines.items()
    ]
    ways = [Connection(f"{name}0_0", (f"{name}1_0",), "a2_0", "s", (1,)) for name in "ab"]
    junction = Junction("j", "priority", np.zeros((1, 2)), (*ways,))
    network = Network("two", lanes, [junction])
    route = Route(np.array([(x, 0.0) for x in range(-30, 31)]))
    places = [*places_along(network, route)]
    (crossing,) = crossings(network, route, places, route.s)
    (conflict,) = crossing.conflicts
    assert (conflict.is_first, conflict.merges, conflict.its_m) == (True, True, (0.0, 0.0))
    assert network.nearest(4.2, -1.0).cross_track_m == pytest.approx(-1.0, abs=0.1)


def test_traffic_drives_on_the_lines_of_the_network(tmp_path):
    sumolib = pytest.importorskip("sumolib")
    network = load_network(write(tmp_path, _DIRECT["exit"]))  # netconvert leaves gaps of 38 m
    net = sumolib.net.readNet(network.net_path, withInternal=True)
    for ours in network.driving:
        shape = np.array(net.getLane(ours.id).getShape())
        assert shape[[0, -1]] == pytest.approx(ours.points_m[[0, -1]], abs=0.5)


def test_lines_and_limits_are_those_of_opendrive(tmp_path):
    network = load_network(write(tmp_path, _MAPS["line"]))
    inner = next(one for one in network.driving if one.right)
    outer = network.lanes[inner.right]
    assert (inner.left_marking, inner.right_marking) == (DOUBLE, BROKEN)
    assert (outer.left_marking, outer.right_marking, outer.left) == (BROKEN, SOLID, inner.id)
    assert inner.speed_limit_mps == pytest.approx(30.0 / 3.6)
    # The line between two lanes is painted once.
    assert [line.kind for line in network.lines()].count(BROKEN) == 1


_TYPE = '<type s="50" type="{}">{}</type>'
_SLOW = '<lane id="-2" type="driving"><speed sOffset="20" max="5"/>'


@pytest.mark.parametrize(
    ("kind", "speed", "limit_mps"),
    [
        ("rural", '<speed max="130" unit="km/h"/>', 130 / 3.6),
        ("rural", '<speed max="60" unit="mph"/>', 26.8224),
        ("rural", '<speed max="no limit"/>', 130 / 3.6),
        ("rural", '<speed max="20" unit=""/>', 20.0),
        ("rural", '<speed max="-1" unit="mph"/>', 50 / 3.6),
        ("motorway", '<speed max="undefined"/>', 130 / 3.6),
    ],
)
def test_limits_of_the_file_apply_each_on_its_stretch(tmp_path, kind, speed, limit_mps):
    text = _MAPS["line"].replace("</type>", "</type>" + _TYPE.format(kind, speed))
    text = text.replace('<lane id="-2" type="driving">', _SLOW)
    network = load_network(write(tmp_path, text))
    left = np.array([-math.sin(0.3), math.cos(0.3)])
    for s_m, t_m, right_mps in (
        (10.0, -5.25, 30 / 3.6),
        (30.0, -5.25, 5.0),
        (60.0, -5.25, 5.0),
        (30.0, -1.75, 30 / 3.6),
        (60.0, -1.75, limit_mps),
        (30.0, 1.75, 30 / 3.6),
        (60.0, 1.75, limit_mps),
    ):
        place = np.array([10.0, -4.0]) + s_m * np.array([left[1], -left[0]]) + t_m * left
        found = network.lanes[network.nearest(*place).lane]
        assert found.speed_limit_mps == pytest.approx(right_mps, abs=0.01)


@pytest.mark.parametrize(
    ("kind", "lanes", "named"),
    [
        ("", 1, "missing"),
        ('driving" direction="reversed', 1, "bidirectional"),
        ("stop", 1, "stop"),
        ("parking", 1, "parking"),
        ("roadWorks", 1, "roadWorks"),
        ("bidirectional", 1, "bidirectional"),
        ("bus", 1, "bus"),
        ("shoulder", 1, "shoulder"),
        ("slipLane", 2, ""),
        ("connectingRamp", 2, ""),
        ("shared", 2, ""),
        ("exit", 2, ""),
    ],
)
def test_cars_drive_on_some_types_of_lanes(tmp_path, kind, lanes, named):
    text = opendrive("<line/>", 80, lane(-1, mark="broken") + lane(-2, kind=kind))
    network = load_network(write(tmp_path, text))
    assert len(network.driving) == lanes
    expected = f"lanes of the type {named} (1, the first: road 7 at 0 m)"
    assert [*network.findings.lines()] == ([expected] if named else [])


@pytest.mark.parametrize("sign", ["", "-"])
def test_borders_of_lanes_are_read_as_widths(tmp_path, sign):
    border = '<border sOffset="{}" a="{}{}" b="{}{}" c="0" d="0"/>'
    inner = border.format(0, sign, 3.5, sign, 0)
    outer = border.format(0, sign, 7.0, sign, 0) + border.format(40, sign, 7.0, sign, 0.05)
    width = '<width sOffset="0" a="3.5" b="0.0" c="0" d="0"/>'
    right = lane(-1).replace(width, inner) + lane(-2).replace(width, outer)
    same = opendrive("<line/>", 80, lane(-1) + lane(-2))
    network = load_network(write(tmp_path, opendrive("<line/>", 80, right)))
    lines = [one.points_m for one in load_network(write(tmp_path, same, "b.xodr")).driving]
    for one, line in zip(network.driving, lines):
        assert one.points_m[0] == pytest.approx(line[0], abs=1e-3)
    # The second lane is 2 m wider at its end.
    ends = [np.hypot(*(a.points_m[-1] - line[-1])) for a, line in zip(network.driving, lines)]
    assert sorted(ends) == pytest.approx([0.0, 1.0], abs=0.01)


def test_cars_change_lanes_only_where_the_line_is_broken(tmp_path):
    marks = "".join(
        f'<roadMark sOffset="{s}" type="{kind}"/>'
        for s, kind in ((0, "solid"), (30, "broken"), (60, "solid"))
    )
    inner = lane(-1).replace('<roadMark sOffset="0" type="solid"/>', marks)
    network = load_network(write(tmp_path, opendrive("<line/>", 80, inner + lane(-2), lane(1))))
    along, right = (
        np.array([math.cos(0.3), math.sin(0.3)]),
        np.array([math.sin(0.3), -math.cos(0.3)]),
    )
    for s_m, is_allowed, kind in ((10.0, False, SOLID), (45.0, True, BROKEN), (70.0, False, SOLID)):
        place = np.array([10.0, -4.0]) + s_m * along + 1.75 * right
        found = network.lanes[network.nearest(*place).lane]
        outer = network.lanes[network.nearest(*(place + 3.5 * right)).lane]
        assert (found.right_marking, outer.left_marking) == (kind, kind)
        assert (found.right, outer.left) == ((outer.id, found.id) if is_allowed else ("", ""))


def test_lanes_with_a_very_low_limit_are_not_for_cars(tmp_path):
    path = town(tmp_path)
    with open(path, encoding="utf-8") as file:
        text = file.read()
    assert len(load_network(path).driving) > 20
    slow = load_network(write(tmp_path, text.replace('speed="8.00"', 'speed="1.39"'), "a.net.xml"))
    assert any(line.startswith("lanes for cars below 2 m/s (") for line in slow.findings.lines())
    streets = {edge_of(one.id).strip("-") for one in slow.driving if not one.junction}
    assert streets == {"a", "b", "c"}
    cars = {one.id for one in slow.driving}
    assert all(cars.issuperset(one.successors) for one in slow.driving if one.junction)


def test_lines_go_on_through_a_junction_in_which_no_ways_cross(tmp_path):
    text = chain(60.0, 30.0, 60.0)
    for other, way in ((1, "successor"), (3, "predecessor")):
        head, found, rest = text.partition(f'id="{other}" junction="-1"')
        rest = re.sub(
            f'<{way} elementType="road" elementId="2"[^>]*>',
            f'<{way} elementType="junction" elementId="9"/>',
            rest,
            count=1,
        )
        text = head + found + rest
    text = text.replace('id="2" junction="-1"', 'id="2" junction="9"')
    ways = "".join(
        f'<connection id="{road}" incomingRoad="{road}" connectingRoad="2" contactPoint="{end}">'
        f'<laneLink from="{lane}" to="{lane}"/></connection>'
        for road, end, lane in ((1, "start", -1), (3, "end", 1))
    )
    junction = f'<junction id="9" name="">{ways}</junction></OpenDRIVE>'
    network = load_network(write(tmp_path, text.replace("</OpenDRIVE>", junction)))
    edges = [dense(line.points_m) for line in network.lines() if line.kind == SOLID]
    assert np.hypot(*(np.vstack(edges) - (75.0, -7.5)).T).min() < 0.1


def test_line_between_lanes_that_begin_at_other_places_is_painted_once():
    def street(number, y_m, start_m, end_m, left, right):
        points = np.array([[start_m, y_m], [end_m, y_m]])
        return RoadLane(f"e_{number}", points, 3.5, 10.0, left, right)

    right = street(0, 0.0, 1.6, 50.0, BROKEN, SOLID)
    left = street(1, 3.5, 0.0, 50.0, SOLID, BROKEN)
    ahead = street(2, 0.0, 50.0, 90.0, BROKEN, NONE)
    kinds = [line.kind for line in Network("two", [right, left, ahead]).lines()]
    assert sorted(kinds) == [BROKEN, BROKEN, SOLID, SOLID]


def test_lines_do_not_fold_where_a_lane_ends_with_a_short_corner():
    points = [*((x, 0.0) for x in np.arange(0.0, 20.1, 0.25)), (20.05, -0.1)]
    lane = RoadLane("corner", np.array(points), 4.0, 10.0, SOLID, SOLID)
    for line in Network("corner", [lane]).lines():
        assert (np.diff(line.points_m[:, 0]) > 0.5).all()
        assert np.abs(np.abs(line.points_m[:, 1]) - 2.0).max() < 0.2


def test_light_of_a_junction_is_not_at_a_joint_of_two_roads_near_it(tmp_path):
    signal = '<signal id="1" s="58" t="-4" dynamic="yes" orientation="+" type="1000001"/>'
    text = chain(60.0, 60.0).replace("</lanes>", f"</lanes><signals>{signal}</signals>", 1)
    network = load_network(write(tmp_path, text))
    assert network.junctions and network.stop_lines == ()
    assert not any(junction.phases for junction in network.junctions.values())


@pytest.mark.parametrize("curvatures", [(0.07, 0.07 - 1e-16), (0.02, 0.02), (0.0, 1e-12)])
def test_spiral_of_one_curvature_behind_a_piece_without_length_is_an_arc(tmp_path, curvatures):
    first, last = curvatures
    spiral = f'<spiral curvStart="{first!r}" curvEnd="{last!r}"/>'
    arc = f'<arc curvature="{first!r}"/>' if first else "<line/>"
    nothing = _PARAM.format("normalized", 0, 0)
    nothing = f'<planView><geometry s="0" x="10" y="-4" hdg="0.3" length="0">{nothing}</geometry>'
    text = opendrive(spiral, 12, lane(-1), lane(1)).replace("<planView>", nothing)
    found = load_network(write(tmp_path, text, "spiral.xodr")).driving
    right = load_network(write(tmp_path, opendrive(arc, 12, lane(-1), lane(1)))).driving
    for one, other in zip(found, right):
        assert one.points_m == pytest.approx(other.points_m, abs=1e-4)


@pytest.mark.slow(4)
@pytest.mark.parametrize(
    ("program", "words"),
    [
        ("sleep 9", "takes more than 0.5 s"),
        (
            "echo 'Error: a is b.' >&2; echo 'Error: c.' >&2; exit 1",
            r"read it: a is b \(and 1 more\)",
        ),
        ("head -c 3000m /dev/zero | tail | wc; exit 1", "cannot read it"),
        ("echo 'std::bad_alloc' >&2; exit 1", "it needs more than 2 GB"),
    ],
)
def test_netconvert_that_fails_is_one_line(tmp_path, monkeypatch, program, words):
    path = write(tmp_path, _MAPS["line"].replace("3.5", "3.3"))
    os.makedirs(tmp_path / "sumo" / "bin")
    os.chmod(write(tmp_path / "sumo" / "bin", "#!/bin/sh\n" + program, "netconvert"), 0o755)
    sumolib = SimpleNamespace(origin=str(tmp_path / "sumolib" / "__init__.py"))
    monkeypatch.setattr("importlib.util.find_spec", lambda _: sumolib)
    monkeypatch.setattr(sumo_programs, "TIMEOUT_S", 0.5 if "sleep" in program else 60.0)
    with pytest.raises(MapError, match=words) as error:
        load_network(path)
    assert "\n" not in str(error.value) and "check the file" in str(error.value)


_UTF_16 = ('<?xml version="1.0" encoding="UTF-16"?>' + _MAPS["line"]).encode("utf-16")


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("MAP.XODR", _UTF_16),
        ("a.xodr", _UTF_16.decode("utf-16").replace("UTF-16", "UTF-8").encode("utf-16")),
        ("a.xodr", _UTF_16.decode("utf-16").encode()),
        ("a.xodr", _MAPS["line"].replace("<road ", "<!-- Straße --><road ").encode("latin-1")),
        ("a.xodr", _UTF_16.decode("utf-16").replace("UTF-16", "gb2312").encode("gb2312")),
        ("map.xodr.gz", gzip.compress(_MAPS["line"].encode())),
    ],
    ids=["UTF-16", "UTF-16 as UTF-8", "UTF-8 as UTF-16", "umlaut without encoding", "GB", "packed"],
)
def test_upper_case_endings_utf_16_and_packed_files_are_read(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    assert len(load_network(str(path)).driving) == 3


def test_lanes_have_the_heights_of_the_file(tmp_path):
    assert load_network(write(tmp_path, _MAPS["line"])).is_flat
    hill = (
        '<elevation s="0" a="2" b="0" c="0.01" d="0"/><elevation s="20" a="6" b="0.4" c="0" d="0"/>'
    )
    hill = f"</planView><elevationProfile>{hill}</elevationProfile>"
    network = load_network(write(tmp_path, _MAPS["line"].replace("</planView>", hill), "hill.xodr"))
    assert not network.is_flat
    for one in network.driving:
        s_m = np.array([0.0, 10.0, 20.0, 50.0])
        s_m = one.length_m - s_m if one.z_m[0] > one.z_m[-1] else s_m
        assert one.height_at(s_m) == pytest.approx([2.0, 3.0, 6.0, 18.0], abs=0.01)


def test_map_in_coordinates_of_the_earth_is_moved_to_the_origin(tmp_path):
    text = _MAPS["line"].replace('x="10"', 'x="549794.5"').replace('y="-4"', 'y="5803123"')
    network = load_network(write(tmp_path, text))
    assert np.abs(network.bounds_m).max() < 200.0
    expected = "places, moved by (-549800, -5803100) m (1, the first: road 7)"
    assert [*network.findings.lines()] == [expected]


def _to_the_east(match):
    return f"{match[1]}{float(match[2]) + 549800.0:.2f}"


def test_network_in_coordinates_of_the_earth_is_moved_to_the_origin(tmp_path):
    path = town(tmp_path)
    with open(path, encoding="utf-8") as file:
        text = re.sub(r'(shape="|(?<=\d) | x=")(-?[\d.]+)(?=[,"])', _to_the_east, file.read())
    network = load_network(write(tmp_path, text, "far.net.xml"))
    east_m = np.array([549800.0 - 549900.0, 0.0] * 2)
    assert network.bounds_m == pytest.approx(load_network(path).bounds_m + east_m, abs=0.01)
    (line,) = network.findings.lines()
    assert line.startswith("places, moved by (-549900, 0) m (1, the first: junction")
    assert load_network(network.net_path).bounds_m == network.bounds_m


_UNREAD = """<lateralProfile><superelevation s="30" a="0.1" b="0" c="0" d="0"/></lateralProfile>
  <signals><signal id="1" s="40" t="0" dynamic="no" orientation="+" type="274"/>
  <signal id="7" s="5" t="0" dynamic="no" orientation="+" type=""/>
  <signal id="8" s="9" t="0" dynamic="yes" orientation="+" type="1"><validity from="1"/></signal>
  <signalReference id="7" s="9" t="0" orientation="+"/></signals>
  <objects><object id="2" s="50" t="0" type="tree"/><object id="3" s="5" t="1i"/></objects>"""
_LINK = '<link><successor elementType="road" elementId="9" contactPoint="start"/></link>'
_WAY = """<junction id="4"><connection id="0" incomingRoad="7" connectingRoad="8"/></junction>
  <junction id="5" type="virtual"/>"""
_BUSES = """<access sOffset="0" rule="allow"><restriction type="bus"/></access>
  <height sOffset="3" inner="0.1" outer="0.1"/><height sOffset="9" inner="0.0" outer="0.0"/>"""


def test_what_is_not_read_is_left_out_and_named(tmp_path):
    text = _MAPS["line"].replace("<link/>", _LINK).replace("</lanes>", "</lanes>" + _UNREAD)
    text = text.replace('<lane id="-2" type="driving">', '<lane id="-2" type="driving">' + _BUSES)
    text = text.replace("</OpenDRIVE>", _WAY + "</OpenDRIVE>").replace(' junction="-1"', "")
    network = load_network(write(tmp_path, text))
    assert len(network.driving) == 2
    assert sorted(network.findings.lines()) == [
        "elements height (1, the first: road 7 at 3 m)",
        "elements superelevation (1, the first: road 7 at 30 m)",
        "junctions of the type virtual (1, the first: junction 5)",
        "lanes for bus (1, the first: lane -7_0)",
        "lights that are at no junction (1, the first: signal 8 of road 7)",
        "links to what the file does not have (2, the first: road 7 to road 9)",
        "objects of the type tree (1, the first: road 7 at 50 m)",
        "objects without t (1, the first: object 3 of road 7)",
        "signals of the type 274 (1, the first: road 7 at 40 m)",
        "signals without type (1, the first: signal 7 of road 7)",
    ]
    (place,) = network.findings.places["objects of the type tree"]
    assert place.point_m == pytest.approx((10 + 50 * math.cos(0.3), -4 + 50 * math.sin(0.3)))


def test_piece_that_begins_later_is_not_continued_backwards(tmp_path):
    late = '<lanes><laneOffset s="40" a="0" b="0.1" c="0" d="0"/>'
    maps = (write(tmp_path, _MAPS["line"].replace("<lanes>", one)) for one in ("<lanes>", late))
    plain, moved = (load_network(path).lanes["-7_1"].points_m for path in maps)
    assert np.hypot(*(moved[[0, -1]] - plain[[0, -1]]).T) == pytest.approx([0.0, 4.0], abs=0.05)


def test_lanes_of_a_town_are_linked(streets):
    for one in streets.lanes.values():
        assert all(one.id in streets.lanes[other].predecessors for other in one.successors)
        assert all(one.id in streets.lanes[other].successors for other in one.predecessors)
        for other in one.successors:
            gap_m = np.hypot(*(streets.lanes[other].points_m[0] - one.points_m[-1]))
            assert gap_m < 0.05
    assert streets.lanes["a_1"].left == "a_2" and streets.lanes["a_2"].right == "a_1"
    assert (streets.lanes["a_0"].kind, streets.lanes["a_1"].right) == (WALKING, "")
    assert len(streets.crosswalks) > 0


def test_right_of_way_and_lines(streets):
    mid = streets.junctions["mid"]
    ways = {(one.start, one.end): one for one in mid.connections}
    from_north, straight = ways["d_1", "e_1"], ways["a_1", "b_1"]
    assert mid.connections.index(straight) in from_north.gives_way_to
    assert mid.connections.index(from_north) not in straight.gives_way_to
    assert (from_north.line, straight.line) == (YIELD, "")
    assert all(streets.lanes[name].junction == "mid" for name in straight.through)


def test_lights_have_phases(streets):
    light = streets.junctions["light"]
    assert {one.line for one in light.connections} == {STOP}
    states = {len(state) for _, state in light.phases}
    assert states == {len(light.phases[0][1])}
    assert max(one.signal for one in light.connections) < states.pop()


def test_one_at_red_has_no_right_of_way(streets):
    light = streets.junctions["light"]
    pairs = [
        (way.connection, first)
        for one in light.connections
        for way in streets.ways[one.start]
        for first in way.first
    ]
    assert pairs  # at green, one that turns left gives way to those that come
    for one, first in pairs:
        both = ({state[one.signal], state[first.signal]} for _, state in light.phases)
        assert any(states <= {"G", "g"} for states in both)
    against = sum(len(one.gives_way_to) for one in light.connections)
    assert len({*pairs}) < against


def test_nearest_lane_prefers_the_direction_of_the_car(streets):
    east = streets.nearest(60.0, 0.3, 0.1)
    west = streets.nearest(60.0, -0.3, math.pi)
    assert (east.lane[0], west.lane[0]) == ("b", "-")
    assert east.heading_error_rad == pytest.approx(0.1, abs=1e-6)
    x, y = streets.lanes[east.lane].at(np.array([east.s_m]))[0]
    assert math.hypot(x - 60.0, y - 0.3) == pytest.approx(abs(east.cross_track_m), abs=1e-6)
    assert streets.nearest(60.0, 80.0, within_m=20.0) is None


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.xodr", "<OpenDRIVE>", "is no XML: no element found: line 1"),
        ("a.xodr", "", "is empty; download"),
        ("a.osm", '<?xml version="1.0" encoding="no"?><osm/>', "no XML: unknown encoding"),
        ("a.xodr", "<html/>", "first element is html, not OpenDRIVE; download"),
        ("a.xodr", "<html><br>", "is a web page, and no map; download"),
        ("a.xodr", "version https://git-lfs.github.com/spec/v1", "Git LFS .* `git lfs pull`"),
        ("a.osm", '<osm><relation><tag k="type" v="lanelet"/></relation></osm>', "map of Lanelet2"),
        ("a.xodr", '<OpenDRIVE><road length="9"/></OpenDRIVE>', "a road has no id; give each one"),
        ("a.xodr", "<net/>", "first element is net, not OpenDRIVE; .* the ending .net.xml"),
        ("a.xodr", _MAPS["line"].replace('x="10"', 'x="nan"'), r"road 7 is at \[nan, -4.0\]"),
        ("a.xodr", _MAPS["line"].replace('length="80" id', 'length="1e9" id'), "from 0 to 100 km"),
        (
            "a.xodr",
            _MAPS["line"].replace("0.3", "nan"),
            "road 7: hdg of an element geometry is nan",
        ),
        ("a.xodr", _MAPS["line"].replace('unit="km/h"', 'unit="kph"'), "road 7: unit 'kph' .* mph"),
        ("a.xodr", _MAPS["line"].replace('id="-2"', 'id="-1"'), "two lanes .* at 0 m have one id"),
        ("a.xodr", _MAPS["line"].replace('laneSection s="0', 'laneSection s="99'), "wrong order"),
        ("a.xodr", re.sub("<width[^>]*>", "", _MAPS["line"]), "a lane for cars with a width"),
        ("a.xodr", _MAPS["line"].replace('lane id="-2"', "lane"), "road 7: an element lacks 'id'"),
        ("a.xodr", _TWICE, "2 roads have the id 7; give each its own"),
        ("a.xodr", _MAPS["line"].replace('id="7"', 'id="my 7"'), "id of road 'my 7' has a blank"),
        ("a.xodr", '<OpenDRIVE><include file="b"/></OpenDRIVE>', "no road; write what is in b in"),
        ("a.net.xml", "<net", "no XML: unclosed token: line 1"),
        ("a.net.xml", '<net><edge id="a" from="b" to="c"/></net>', "no complete network"),
        ("a.net.xml", '<net version="1.20"/>', "no lane for cars"),
        ("a.csv", "", "no map by its ending; name a .xodr"),
        ("a.osm.pbf", "", "osmium cat"),
    ],
)
def test_bad_map_is_one_line(tmp_path, name, text, words):
    path = write(tmp_path, text, name)
    with pytest.raises(MapError, match=words) as error:
        load_network(path)
    assert path in str(error.value) and "\n" not in str(error.value)


def test_map_in_the_cache_needs_no_netconvert(tmp_path, monkeypatch):
    path = write(tmp_path, _MAPS["arc"])
    first = load_network(path)
    monkeypatch.setattr("subprocess.run", None)
    os.utime(path, (1, 1))
    assert np.array_equal(load_network(path).driving[0].points_m, first.driving[0].points_m)


def test_missing_netconvert_is_one_line_that_names_the_fix(tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    path = write(tmp_path, _MAPS["line"].replace("3.5", "3.4"))
    with pytest.raises(MapError, match="^netconvert .* is missing; run .*maps"):
        load_network(path)
