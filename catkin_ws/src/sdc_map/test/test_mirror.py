"""Maps with traffic on the left: OpenDRIVE, networks of SUMO, and the packaged town."""

import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from opendrive_geometry import lane_centre_lines
from scipy.spatial import cKDTree
from test_network import chain

from sdc_map.map_file import map_file
from sdc_map.mirror import mirror_opendrive, mirrored
from sdc_map.network import BROKEN, SOLID, Network, RoadLane
from sdc_map.network_file import MapError, load_network
from sdc_testing.street_maps import dense, lane, needs_maps, opendrive, town, write

pytestmark = needs_maps
_OFFSET = '<laneOffset s="0" a="0" b="{0}0.04" c="{0}.001" d="0"/>'
_CROSSWALK = """<objects><object id="1" type="crosswalk" s="20" t="{0}2" zOffset="0" hdg="{0}1.2"
  orientation="none" length="4" width="3"><outline><cornerLocal u="-2" v="{0}-1" z="0"/>
  <cornerLocal u="2" v="{0}-1" z="0"/><cornerLocal u="2" v="{0}2" z="0"/>
  <cornerLocal u="-2" v="{0}2" z="0"/></outline></object></objects>"""
_SHAPES = {
    "arc": '<arc curvature="{0}0.05"/>',
    "spiral": '<spiral curvStart="0" curvEnd="{0}-0.08"/>',
    "poly3": '<poly3 a="0" b="0" c="{0}0.004" d="{0}5e-5"/>',
    "paramPoly3": '<paramPoly3 aU="0" bU="30" cU="0" dU="0" aV="0" bV="0" cV="{0}2" dV="0"/>',
}


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / "cache"))


def signed(text, sign):
    """Return a text with a sign before its marked numbers."""
    return text.format(sign).replace("--", "")


def assert_is_mirror_image(left, right):
    """Check the lanes, crosswalks and ways of a network with traffic on the left."""
    assert [*left.lanes] == [*right.lanes] and (left.y_sign, right.y_sign) == (-1.0, 1.0)
    for one, other in zip(left.lanes.values(), right.lanes.values()):
        assert one.points_m == pytest.approx(other.points_m * (1.0, -1.0), abs=1e-4)
        sides = other.right, other.left, other.right_marking, other.left_marking
        assert (one.left, one.right, one.left_marking, one.right_marking) == sides
        assert one.speed_limit_mps == other.speed_limit_mps
    assert len(left.crosswalks) == len(right.crosswalks)
    for area, other in zip(left.crosswalks, right.crosswalks):
        assert area == pytest.approx(other * (1.0, -1.0), abs=1e-3)
    for name, junction in left.junctions.items():
        turns = [one.direction for one in junction.connections]
        others = [one.direction for one in right.junctions[name].connections]
        assert "".join(turns).translate(str.maketrans("lrLR", "rlRL")) == "".join(others)


@pytest.mark.parametrize("name", _SHAPES)
def test_file_with_traffic_on_the_left_is_the_mirror_image_of_one_on_the_right(tmp_path, name):
    one, two = lane(1), lane(-1, mark="broken") + lane(-2, (3.0, 0.02))
    files = []
    for sign, rule, sides in (("-", 'rule="LHT"', (one, two)), ("", "", (two, one))):
        if sign:  # the same lanes, on the other sides of the road
            sides = [re.sub('lane id="(-?)', _other_sign, side) for side in sides]
        text = opendrive(signed(_SHAPES[name], sign), 30, *sides, signed(_OFFSET, sign))
        text = text.replace('junction="-1"', f'junction="-1" {rule}')
        text = text.replace("</lanes>", "</lanes>" + signed(_CROSSWALK, sign))
        if sign:
            text = text.replace('y="-4" hdg="0.3"', 'y="4" hdg="-0.3"')
        files.append(write(tmp_path, text, f"{rule[-4:-1]}.xodr"))
    left, right = map(load_network, files)
    assert len(left.driving) == 3 and len(left.crosswalks) == 1
    assert_is_mirror_image(left, right)
    inner = next(one for one in left.driving if one.left)
    assert (inner.left_marking, left.lanes[inner.left].left_marking) == (BROKEN, SOLID)
    lines = cKDTree(np.vstack([dense(line) for line in lane_centre_lines(files[0])]))
    assert max(lines.query(dense(one.points_m))[0].max() for one in left.driving) < 0.05


def _other_sign(match):
    return 'lane id="' + ("" if match[1] else "-")


def test_cars_drive_on_the_left_lane_along_roads_that_follow_one_another(tmp_path):
    text = chain(60.0, 40.0).replace("<road ", '<road rule="LHT" ')
    network = load_network(write(tmp_path, text))
    there = network.lanes[network.nearest(30.0, -2.25, 0.0).lane]
    assert there.heading_at(1.0) == pytest.approx(0.0, abs=1e-6)
    assert network.straight_on(network.straight_on(there)).points_m[0][1] == pytest.approx(-2.25)
    back = network.lanes[network.nearest(30.0, -5.75).lane]
    assert abs(back.heading_at(1.0)) == pytest.approx(np.pi, abs=1e-6)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('<link><predecessor id="1"/><successor id="-2"/></link>', "predecessor -1 successor 2"),
        ('<road rule="LHT"><link><successor elementId="5"/></link></road>', "road RHT successor 5"),
        ('<laneLink from="1" to="-2"/>', "laneLink -1 2"),
        ('<validity fromLane="-2" toLane="-1"/>', "validity 1 2"),
        ('<signal id="3" s="1" t="-2.5" orientation="+" hOffset="0.1"/>', "signal 3 1 2.5 + -0.1"),
        ('<object id="3" s="1" t="+2" hdg="1e-1" roll=""/>', "object 3 1 -2 -1e-1 "),
        ('<cornerLocal u="1" v="2" z="0.0"/>', "cornerLocal 1 -2 0.0"),
        ('<repeat s="1" tStart="1" tEnd="-2"/>', "repeat 1 -1 2"),
        ('<elevation s="1" a="2" b="0.01" c="0" d="0"/>', "elevation 1 2 0.01 0 0"),
        ('<width sOffset="1" a="2" b="0.01" c="0" d="0"/>', "width 1 2 0.01 0 0"),
        ('<border sOffset="1" a="2" b="0" c="0" d="0"/>', "border 1 -2 0 0 0"),
        ('<roadMark laneChange="increase"/>', "roadMark decrease"),
        (
            '<laneSection s="1"><left><lane id="2"/><lane id="1"/></left><center><lane id="0"/>'
            '</center><right><lane id="-1"/></right></laneSection>',
            "laneSection 1 left lane 1 center lane 0 right lane -1 lane -2",
        ),
    ],
)
def test_elements_of_opendrive_in_the_mirror(text, expected):
    root = ElementTree.fromstring(text)
    mirror_opendrive(root)
    words = (" ".join([one.tag, *one.attrib.values()]) for one in root.iter() if one.tag != "link")
    assert " ".join(words) == expected


def test_file_with_both_rules_is_refused_with_a_road_of_each(tmp_path):
    text = chain(60.0, 40.0, 50.0).replace('id="2"', 'id="2" rule="lht"', 1)
    words = r'road 2 has left-hand traffic \(rule="LHT"\), and road 1 not; give all roads one rule'
    with pytest.raises(MapError, match=words):
        load_network(write(tmp_path, text))


@pytest.mark.slow(6)
def test_opendrive_of_the_town_is_driven_on_the_left_in_its_mirror_image(tmp_path):
    path = map_file("town").replace(".net.xml", ".xodr")
    tree = ElementTree.parse(path)
    mirror_opendrive(tree.getroot())
    left, right = (
        load_network(write(tmp_path, text, name))
        for name, text in (
            ("left.xodr", ElementTree.tostring(tree.getroot(), "unicode")),
            ("right.xodr", open(path, encoding="utf-8").read()),  # noqa: SIM115
        )
    )
    assert_is_mirror_image(left, right)
    lines = cKDTree(np.vstack(lane_centre_lines(tmp_path / "left.xodr")))
    outside = [one for one in left.driving if not one.junction]
    assert max(lines.query(dense(one.points_m))[0].max() for one in outside) < 0.1


def test_places_of_what_is_left_out_are_those_of_the_map():
    right = Network("a", [RoadLane("a_0", np.array([(0.0, 0.0), (9.0, 3.0)]), 3.5, 9.0)])
    right.findings.add("bends", "a_0 at (3, -4)", point_m=(3.0, -4.0))
    ((place,),) = mirrored(right).findings.places.values()
    assert (place.text, place.point_m) == ("a_0 at (3, 4)", (3.0, 4.0))


@pytest.mark.parametrize("name", ["a.net.xml", "a.NET.XML"])
def test_network_of_sumo_with_traffic_on_the_left_has_neighbours_on_their_sides(tmp_path, name):
    path = town(tmp_path, name=name, more=("--lefthand",))
    network = load_network(path)
    pairs = [(one, network.lanes[one.left]) for one in network.driving if one.left]
    assert pairs and network.y_sign == -1.0
    for one, other in pairs:
        x, y = other.points_m[0] - one.points_m[0]
        heading = one.heading_at(0.0)
        assert y * np.cos(heading) - x * np.sin(heading) == pytest.approx(3.2, abs=0.01)
    assert network.nearest(-100.0, 1.6, 0.0).lane.startswith("a_")  # to the east
    ways = [one for each in network.junctions.values() for one in each.connections]
    for way in ways:
        before, after = network.lanes[way.start], network.lanes[way.end]
        turned = np.sin(after.heading_at(0.0) - before.heading_at(before.length_m))
        assert way.direction == ("l" if turned > 0.7 else "r" if turned < -0.7 else "s")
    assert network.net_path != path and load_network(network.net_path).y_sign == 1.0


def test_town_left_is_the_mirror_image_of_the_town():
    left, right = load_network("town_left"), load_network("town")
    assert [*left.findings.lines()] == [*right.findings.lines()]
    assert_is_mirror_image(left, right)
    assert left.name == "town_left" and left.net_path == right.net_path
    assert len(left.bays) == 38
    for area in left.bays:
        assert left.nearest(*area.mean(axis=0)).cross_track_m > 1.5
    one, other = left.nearest(60.0, -80.0, 0.4), right.nearest(60.0, 80.0, -0.4)
    assert (one.lane, one.s_m, one.cross_track_m) == (other.lane, other.s_m, -other.cross_track_m)
