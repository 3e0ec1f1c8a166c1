"""Streets of OpenStreetMap."""

import numpy as np
import pytest
from test_mirror import assert_is_mirror_image

from sdc_map.lane_graph import LaneGraph
from sdc_map.mission import plan_mission
from sdc_map.network import DRIVING, WALKING, edge_of
from sdc_map.network_file import MapError, load_network
from sdc_testing.street_maps import needs_maps, write

pytestmark = needs_maps

# Length of a degree of latitude at 52 degrees north [m].
_NORTH_M = 111_267.0
# Length of a degree of longitude there [m].
_EAST_M = 68_678.0
_LIGHT = {"highway": "traffic_signals"}
# Nodes by their ids: place to the east and north [m] and tags. Main Street is 600 m long from west
# to east; Side Street crosses it at (0, 0), with lights 15 m before the crossing on Main Street.
_NODES = {
    1: (-300, 0, {}),
    2: (-15, 0, _LIGHT),
    3: (0, 0, {}),
    4: (15, 0, _LIGHT),
    5: (300, 0, {}),
    6: (0, 200, {}),
    7: (0, -200, {}),
    8: (-200, 0, {"railway": "level_crossing"}),
    9: (-200, 90, {}),
    10: (-200, -90, {}),
    11: (150, 0, {}),
    12: (150, 40, {}),
    13: (150, -100, {"barrier": "bollard"}),
    14: ("nan", "nan", {}),
}
_WAYS = {
    100: ([1, 8, 2, 3, 4, 11, 5], {"highway": "secondary", "maxspeed": "DE:urban"}),
    101: ([6, 3, 99, 14, 7], {"highway": "residential", "maxspeed": "20 mph"}),
    102: ([9, 8, 10], {"railway": "rail"}),
    103: ([11, 12], {"highway": "service", "service": "driveway"}),
    104: ([11, 13], {"highway": "residential"}),
    105: ([9, 12], {"highway": "footway"}),
    106: ([7, 13], {"highway": "residential", "access": "private"}),
}


def osm(nodes=None, ways=None, middle=(52, 10)):
    """Return a file of OpenStreetMap around a latitude and a longitude."""

    def element(tag, number, attributes, tags, inner=""):
        texts = "".join(f'<tag k="{key}" v="{value}"/>' for key, value in tags.items())
        return f'<{tag} id="{number}" {attributes}>{inner}{texts}</{tag}>'

    lines = ['<osm version="0.6">']
    for number, (east, north, tags) in (nodes or _NODES).items():
        lat, lon = middle[0] + float(north) / _NORTH_M, middle[1] + float(east) / _EAST_M
        place = f'lat="{lat}" lon="{lon}"'
        lines.append(element("node", number, place, tags))
    for number, (names, tags) in (ways or _WAYS).items():
        refs = "".join(f'<nd ref="{name}"/>' for name in names)
        lines.append(element("way", number, "", tags, refs))
    return "\n".join([*lines, "</osm>"])


@pytest.fixture(scope="module", name="town")
def _town(tmp_path_factory):
    return load_network(write(tmp_path_factory.mktemp("osm"), osm(), "town.osm"))


def test_streets_are_around_the_middle_of_the_map(town):
    assert town.bounds_m == pytest.approx((-300.0, -200.0, 300.0, 200.0), abs=4.0)
    mission = plan_mission(LaneGraph(town), [(250.0, -1.6)], -250.0, -1.6)
    assert mission.ends_m == pytest.approx((500.0,), abs=1.0)


def test_only_streets_for_cars_and_their_sidewalks_are_read(town):
    streets = {edge_of(name).partition("#")[0] for name in town.lanes if name[0] != ":"}
    assert {name.lstrip("-") for name in streets} == {"100", "101", "104"}
    kinds = {lane.kind for lane in town.lanes.values()}
    assert kinds == {DRIVING, WALKING}
    assert "rail_crossing" not in {one.kind for one in town.junctions.values()}
    assert len(town.crosswalks) >= 4


def test_pedestrians_cross_the_mouth_of_a_slow_street_on_a_crosswalk(tmp_path):
    ways = {100: ([1, 3, 5], {"highway": "primary"}), 101: ([3, 6], {"highway": "service"})}
    network = load_network(write(tmp_path, osm(ways=ways), "a.osm"))
    sidewalks = {edge_of(lane.id) for lane in network.lanes.values() if lane.kind == WALKING}
    assert {"101", "-101"} <= sidewalks
    middles = [area.mean(axis=0) for area in network.crosswalks]
    assert any(abs(x) < 3.0 and -98.0 < y < -90.0 for x, y in middles)  # north of (0, -100)


def test_limits_are_those_of_the_file_or_of_the_kind_of_street(town):
    found = {
        round(lane.speed_limit_mps, 2)
        for lane in town.driving
        if not lane.junction and lane.id.lstrip("-").startswith(("100", "101"))
    }
    assert found == {13.89, 8.94}
    (beside,) = {
        round(lane.speed_limit_mps, 2) for lane in town.driving if lane.id.lstrip("-")[:3] == "104"
    }
    assert beside == 13.89


def test_lights_before_a_crossing_are_those_of_the_crossing(town):
    (junction,) = (one for one in town.junctions.values() if one.phases)
    assert np.hypot(*junction.polygon_m.mean(axis=0)) < 3.0
    starts = {one.start for one in junction.connections if one.signal >= 0}
    assert len(starts) == 4


def test_what_is_not_in_the_map_is_named(town):
    found = {kind: [one.text for one in places] for kind, places in town.findings.places.items()}
    assert found == {
        "points of streets with railway=level_crossing": ["node 8"],
        "points of streets with barrier=bollard": ["node 13"],
        "nodes that the file lacks": ["node 99"],
        "nodes without a valid place": ["node 14"],
        "ways with railway=rail": ["way 102"],
        "ways with highway=service, driveways": ["way 103"],
        "ways with highway=residential without a limit, read as 50 km/h": ["way 104"],
        "ways with highway=footway": ["way 105"],
        "ways with highway=residential, closed to cars": ["way 106"],
    }
    (place,) = town.findings.places["points of streets with barrier=bollard"]
    assert place.point_m == pytest.approx((150.0, -100.0), abs=0.5)


@pytest.mark.parametrize(
    ("limit", "limit_mps"),
    [("30", 8.33), ("30 km/h", 8.33), ("DE:zone30", 8.33), ("FR:50", 13.89)]
    + [("none", 36.11), ("walk", 2.78), ("signals", None), ("0", None)],
)
def test_words_of_limits_are_read(tmp_path, limit, limit_mps):
    tags = {"highway": "primary", "maxspeed": limit, "access": "no", "motorcar": "yes"}
    ways = {100: ([1, 5], tags)}
    network = load_network(write(tmp_path, osm(ways=ways), "a.osm"))
    found = [round(lane.speed_limit_mps, 2) for lane in network.driving]
    assert found == [limit_mps or 13.89] * len(found)
    named = [] if limit_mps else [f"limits of the kind {limit}, not read (1, the first: way 100)"]
    assert [*network.findings.lines()] == named


@pytest.mark.parametrize(
    ("ways", "words"),
    [
        ({100: ([1, 5], {"highway": "footway"})}, "no street for cars, only footway; export"),
        ({100: ([1, 5], {"building": "yes"})}, "no way with the key highway; export"),
        ({100: ([14, 99], {"highway": "primary"})}, "no street for cars"),
    ],
)
def test_file_without_streets_is_one_line(tmp_path, ways, words):
    path = write(tmp_path, osm(ways=ways), "a.osm")
    with pytest.raises(MapError, match=words) as error:
        load_network(path)
    assert str(error.value).startswith(path) and "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("nodes", "tags", "named"),
    [
        ([1, 5], {"lanes": "9999"}, "lanes=9999, not read"),
        ([1, 5], {"width": "0.5"}, "width=0.5, not read"),
        ([1, 5], {"lanes": "3", "lanes:both_ways": "1"}, "ways with lanes:both_ways, not for cars"),
        ([1, 2, 3], {}, "lights that are at no junction"),
    ],
)
def test_what_a_street_does_not_have_is_named(tmp_path, nodes, tags, named):
    ways = {100: (nodes, {"highway": "primary", "maxspeed": "50", **tags})}
    network = load_network(write(tmp_path, osm(ways=ways), "a.osm"))
    assert len(network.driving) == 2
    assert [*network.findings.places] == [named]


def test_streets_on_two_continents_are_one_line(tmp_path):
    nodes = {1: (0, 0, {}), 2: (500_000, 0, {})}
    ways = {100: ([1, 2], {"highway": "primary"})}
    with pytest.raises(MapError, match="farther than 100 km apart; export a smaller area"):
        load_network(write(tmp_path, osm(nodes, ways), "a.osm"))


_STREET = {"highway": "primary", "maxspeed": "50"}
_RING = {**_STREET, "junction": "roundabout"}
_LEFT = {"driving_side": "left"}
_RING_NODES = {1: (0, 20, {}), 2: (20, 0, {}), 3: (0, -20, {}), 4: (-20, 0, {}), 5: (90, 0, {})}
_SILENT = "the file does not say"


@pytest.mark.parametrize(
    ("tags", "ring", "address", "middle", "is_left", "reason"),
    [
        ({}, {}, {}, (52, 10), False, _SILENT),
        ({}, _STREET, {}, (52, 10), False, _SILENT),
        (_LEFT, {}, {}, (52, 10), True, "by driving_side"),
        ({}, {}, _LEFT, (52, 10), True, "by driving_side"),
        ({"driving_side": "right"}, _RING, {}, (52, -1), False, "by driving_side"),
        ({}, _RING, {"addr:country": "DE"}, (52, 10), True, "by its roundabouts"),
        ({}, {**_RING, "oneway": "-1"}, {}, (52, -1), False, "by its roundabouts"),
        ({}, {}, {"addr:country": "GB"}, (52, 10), True, "by the country of its addresses"),
        ({}, {}, {"addr:country": "FR"}, (52, -1), False, "by the country of its addresses"),
        ({}, {}, {"is_in:country": "United Kingdom"}, (52, -1), True, "by its place"),
        ({}, {}, {}, (30.7, 76.8), True, "by its place"),
    ],
)
def test_side_of_traffic_is_found(tmp_path, tags, ring, address, middle, is_left, reason):
    nodes = {**_RING_NODES, 6: (50, 50, address)}
    ways = {100: ([2, 5], {**_STREET, **tags}), 101: ([1, 2, 3, 4, 1], ring)}
    network = load_network(write(tmp_path, osm(nodes, ways, middle), "a.osm"))
    assert (network.y_sign < 0.0, network.findings.side) == (is_left, reason)


def test_few_streets_with_traffic_on_the_other_side_are_named(tmp_path):
    ways = {100: ([1, 3], {**_STREET, **_LEFT}), 101: ([3, 6], _STREET), 102: ([3, 7], _STREET)}
    network = load_network(write(tmp_path, osm(ways=ways), "a.osm"))
    assert network.y_sign > 0.0
    text = "ways with driving_side=left, not read (1, the first: way 100)"
    assert [*network.findings.lines()] == [text]


def test_streets_with_traffic_on_the_left_are_the_mirror_image_of_those_on_the_right(tmp_path):
    networks = []
    for side, sign, turns, placement in (
        ("left", 1, "left|through|through;right", "right_of:1"),
        ("right", -1, "left;through|through|right", "left_of:3"),
    ):
        more = {"oneway": "yes", "lanes": "3", "turn:lanes": turns, "placement": placement}
        one_way = {**_STREET, **more, f"sidewalk:{side}": "yes"}
        ways = {
            100: ([1, 3], {**one_way, "driving_side": side}),
            101: ([3, 5], {**_STREET, "lanes": "4", "driving_side": side}),
            102: ([6, 3, 7], {**_STREET, "highway": "residential"}),
        }
        nodes = {name: (x, sign * float(y), {}) for name, (x, y, _) in _NODES.items()}
        text = osm(nodes, ways, (52 * sign, 10))
        networks.append(load_network(write(tmp_path, text, f"{side}.osm")))
    left, right = networks
    assert_is_mirror_image(left, right)
    assert left.nearest(200.0, 1.6, 0.0).lane.startswith("101")
    assert left.nearest(200.0, -1.6, np.pi).lane.startswith("-101")
