"""Read a network from OpenDRIVE, OpenStreetMap or SUMO (.xodr, .osm, .net.xml).

SUMO's Python package `sumolib` reads what `netconvert` makes of a file, and `opendrive_lanes` what
netconvert does not read.

python3 -m sdc_map.network_file MAP [--lanes] prints what is in a map, and the lanes.
"""

from __future__ import annotations

import gzip
import importlib
import itertools
import math
import os
import re
import sys
import xml.etree.ElementTree as ElementTree
from functools import lru_cache
from typing import Any, Iterator
from xml.sax import SAXException

import numpy as np
from scipy.spatial import cKDTree

from sdc_common.configuration import how_to_install
from sdc_common.geometry.road_line import arc_lengths
from sdc_common.geometry.route import interpolate
from sdc_common.validation import DocumentError
from sdc_map.drivable import joint, without_bends
from sdc_map.findings import Findings
from sdc_map.map_file import map_file
from sdc_map.mirror import mirrored
from sdc_map.netconvert import POLYGONS, map_source, net_with_lines
from sdc_map.network import (
    BICYCLE,
    BROKEN,
    DOUBLE,
    DRIVING,
    KERB,
    NONE,
    OTHER,
    SOLID,
    STOP,
    WALKING,
    YIELD,
    Connection,
    Junction,
    Network,
    RoadLane,
    left_normals,
    part_of,
)
from sdc_map.opendrive_file import FARTHEST_M
from sdc_map.opendrive_lanes import OpenDriveLanes
from sdc_map.sumo_programs import MapError

# Lanes with a lower limit, such as those of car parks in SUMO, are not for cars.
_SLOWEST_MPS = 2.0
# Traffic drives on the lines of netconvert where those of the network are nearer [m].
_BESIDE_M = 0.5
# A light is so near to the middle of its junction [m].
_LIGHT_M = 60.0
# Lanes that the file links are so near to each other [m].
_APART_M = 1.0
# More lanes take more than a minute, and more than 2 GB.
_MOST_LANES = 100_000
_UNCROSSED = (SOLID, DOUBLE, KERB)
# By the letter of SUMO's connections: those that must stop or give way.
_LINES = {"s": STOP, "w": STOP, "m": YIELD}


def load_network(path: str) -> Network:
    """Return the network of a map, a file or a packaged name; read again when the file changes.

    Raises:
        MapError: the file is no map, or what reads it is not installed
    """
    path = map_file(path)
    try:
        return _loaded(path, os.stat(path).st_mtime_ns)
    except OSError as error:
        raise MapError(f"{path}: cannot be read ({error.strerror}); name a map") from None


@lru_cache(maxsize=2)
def _loaded(path: str, _: int) -> Network:
    name, source = os.path.basename(path).partition(".")[0], map_source(path)
    own, findings = source.opendrive, source.findings
    try:
        from sumolib.net import readNet
    except ImportError:
        raise MapError(
            f"{path}: the Python package sumolib is missing; {how_to_install('town')}"
        ) from None
    options = dict.fromkeys(("withInternal", "withPrograms", "withPedestrianConnections"), True)
    try:
        _check_size(source.net_path)
        net = readNet(source.net_path, **options)
        _check(net)
        crosswalks = list(_polygons(source.net_path)) if own else []
        places = re.sub(r"(?i)\.net\.xml(\.gz)?$", ".add.xml", path)
        if not os.path.exists(places):  # those of the map of which this one is the mirror image
            places = source.net_path.replace(".net.xml", ".add.xml")
        places = "" if places == path else places
        network = _network(name, net, own, crosswalks, places, findings)
    except DocumentError as error:
        raise MapError(f"{path}: {error}") from None
    except (ValueError, LookupError, AttributeError, TypeError, SAXException) as error:
        text = f"is no complete network of SUMO ({error!r})"
        raise MapError(f"{path}: {text}; make it again with netconvert") from None
    network.net_path, network.findings = source.net_path, findings
    # On a shoulder of OpenDRIVE, whose type its reader names, netconvert lets authorities drive.
    _name_unread(net, "" if own is None else "authority", findings)
    if own is not None:
        network.net_path = _net_of_traffic(net, network)
        lit = [one.polygon_m.mean(axis=0) for one in network.junctions.values() if one.phases]
        for text, point_m in own.lights:
            if not any(math.dist(point_m, middle_m) < _LIGHT_M for middle_m in lit):
                findings.add("lights that are at no junction", text, point_m)
    return mirrored(network) if source.is_mirror else network


def _net_of_traffic(net: Any, network: Network) -> str:
    """Return SUMO's network with the lines of lanes that are elsewhere in ours."""
    lines_m = {}
    for name, lane in network.lanes.items():
        shape_m = _points(net.getLane(name).getShape3D())[:, :2]
        ends_m = np.hypot(*(lane.points_m[[0, -1]] - shape_m[[0, -1]]).T)
        if max(*ends_m, *cKDTree(lane.points_m).query(shape_m)[0]) > _BESIDE_M:
            lines_m[name] = np.column_stack([lane.points_m, lane.z_m])
    return net_with_lines(network.net_path, lines_m) if lines_m else network.net_path


def _check_size(path: str) -> None:
    """Raise DocumentError for a network of SUMO that would take more than a minute."""
    with gzip.open(path) if path.endswith(".gz") else open(path, "rb") as file:
        count = sum(line.count(b"<lane ") for line in file)
    if count > _MOST_LANES:
        text = f"has {count} lanes, and at most {_MOST_LANES} are read"
        raise DocumentError(f"{text}; read a smaller area")


def _check(net: Any) -> None:
    """Raise DocumentError for a network on which no car can drive."""
    lanes = [lane for edge in net.getEdges() for lane in edge.getLanes()]
    for lane in lanes:
        x_m, y_m = max(lane.getShape(), key=lambda point: float(np.abs(point).max()))
        if not max(abs(x_m), abs(y_m)) < FARTHEST_M:
            text = f"lane {lane.getID()} is at ({x_m:.0f}, {y_m:.0f}) m"
            raise DocumentError(f"{text}, which is no place within 100 km; correct it there")
    if DRIVING not in map(_kind, lanes):
        text = f"has no lane for cars with a limit of {_SLOWEST_MPS:g} m/s or more"
        raise DocumentError(f"{text}; read a map with streets")


def _name_unread(net: Any, named: str, findings: Findings) -> None:
    """Add lanes on which no car, bicycle or pedestrian goes, and rail crossings.

    Those of the users `named` are named already.
    """
    for lane in (lane for edge in net.getEdges(False) for lane in edge.getLanes()):
        place = f"lane {lane.getID()}"
        kind, point_m = _kind(lane), tuple(lane.getShape()[0][:2])
        if kind != DRIVING and lane.allows("passenger"):
            findings.add("lanes for cars below 2 m/s", place, point_m)
        users = min(lane.getPermissions(), default="no one")
        if kind == OTHER and not lane.allows("passenger") and users != named:
            findings.add(f"lanes for {users}", place, point_m)
    for node in net.getNodes():
        if node.getType() in ("rail_crossing", "rail_signal"):
            place = f"junction {node.getID()}"
            findings.add("crossings of rails, always open", place, node.getCoord())


def _network(
    name: str,
    net: Any,
    own: OpenDriveLanes | None,
    crosswalks: list,
    places: str,
    findings: Findings,
) -> Network:
    edges = [edge for edge in net.getEdges() if edge.getFunction() in ("", "internal")]
    sources = {lane.getID(): lane for edge in edges for lane in edge.getLanes()}
    leads: dict[str, list[str]] = {name: [] for name in sources}
    comes: dict[str, list[str]] = {name: [] for name in sources}
    for start, lane in sources.items():
        for connection in lane.getOutgoing():
            following = connection.getViaLaneID() or connection.getToLane().getID()
            if following in sources:
                leads[start].append(following)
                comes[following].append(start)
    lines = {name: _points(lane.getShape3D()) for name, lane in sources.items()}
    if own is not None:
        _take_lines_of_file(lines, sources, own, leads, findings)
    lanes = [_lane(lane, lines, own, leads[name], comes[name]) for name, lane in sources.items()]
    lanes = without_bends(lanes, findings)
    for edge in net.getEdges():
        for lane in edge.getLanes() if edge.getFunction() == "crossing" else ():
            line = RoadLane("", _points(lane.getShape())[:, :2], lane.getWidth(), 0.0)
            crosswalks.append(line.area_m)
    junctions = [_junction(net, node, leads) for node in net.getNodes()]
    bays, stops = _places(places, {lane.id: lane for lane in lanes})
    return Network(name, lanes, junctions, crosswalks, bays, stops)


def _neighbour(lane: Any, step: int, lines: dict[str, np.ndarray]) -> str:
    """Return the lane of the same kind on the left (1) or right (-1) of a lane, "" if none is."""
    lanes, number = lane.getEdge().getLanes(), lane.getIndex() + step
    if not 0 <= number < len(lanes) or _kind(lanes[number]) != _kind(lane):
        return ""
    name = lanes[number].getID()
    apart_m = _three_places(lines[lane.getID()]) - _three_places(lines[name])
    width_m = lane.getWidth() + lanes[number].getWidth()
    return name if np.hypot(*apart_m.T).max() < width_m else ""


def _three_places(line: np.ndarray) -> np.ndarray:
    """Return the start, the middle and the end (3, 2) of a line [m]."""
    s = arc_lengths(line)
    return interpolate(s[-1] * np.array([0.0, 0.5, 1.0]), s, line[:, :2])


def _places(path: str, lanes: dict[str, RoadLane]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return parking bays and bus stops of SUMO's additional file beside a network, if any."""
    bays: list[np.ndarray] = []
    stops: list[np.ndarray] = []
    for one in ElementTree.parse(path).getroot() if os.path.exists(path) else ():
        lane = lanes.get(one.get("lane", ""))
        if lane is None or one.tag not in ("parkingArea", "busStop"):
            continue
        is_stop = one.tag == "busStop"
        count = 1 if is_stop else int(one.get("roadsideCapacity", 0))
        ends = np.linspace(float(one.get("startPos", 0)), float(one.get("endPos", 0)), count + 1)
        across = float(one.get("angle", 0)) > 45.0
        depth_m = float(one.get("length" if across else "width", 5.0 if across else 2.5))
        edge_m = -0.5 * lane.width_m
        for start, end in zip(ends, ends[1:]):
            at = np.array([start, end])
            points, left = lane.at(at), left_normals(lane.at(at))
            inner, outer = edge_m, 0.0 if is_stop else edge_m - depth_m
            area = np.vstack([points + inner * left, (points + outer * left)[::-1]])
            (stops if is_stop else bays).append(area)
    return bays, stops


def _points(shape: Any) -> np.ndarray:
    """Return the points of a shape, each apart from the one before it, and at least two."""
    points = np.array(shape, float)
    apart = np.append(True, np.hypot(*np.diff(points[:, :2], axis=0).T) > 1e-3)
    apart[-1] |= apart.sum() < 2
    return points[apart]


def _take_lines_of_file(
    lines: dict[str, np.ndarray],
    sources: dict,
    own: OpenDriveLanes,
    leads: dict[str, list[str]],
    findings: Findings,
) -> None:
    """Replace the centre lines of netconvert by those of OpenDRIVE.

    netconvert cuts roads where its junctions begin, which overlap where a road is short, and gives
    a lane one width. A road has its whole length here, and lanes in junctions join both ends.
    """
    outside = {name: lane for name, lane in sources.items() if name[0] != ":"}
    for name, lane in outside.items():
        road, number = _origin(lane)
        if road:
            line = own.line(road, number, *_ends_m(lane, own, road, number))
            if line is not None:
                lines[name] = _points(line)
    for name, lane in outside.items():
        for connection in lane.getOutgoing():
            end = connection.getToLane().getID()
            through = list(_through(connection, leads))
            if end not in lines or not through:
                continue
            choices = own.through(*_origin(sources[through[0]])), [lines[one] for one in through]
            found = [np.vstack(line) for line in choices if line is not None]
            if choices[0] is not None:
                ends_m = np.vstack([lines[name][-1], lines[end][0]]) - found[0][[0, -1]]
                apart_m = float(np.hypot(*ends_m[:, :2].T).max())
                if apart_m > _APART_M:
                    text = f"{name} to {end}, {apart_m:.0f} m"
                    findings.add("linked lanes that do not meet", text, tuple(found[0][0, :2]))
            line = joint(lines[name], lines[end], found)
            # Those of netconvert may have no length.
            lengths_m = [max(arc_lengths(lines[one])[-1], 1e-3) for one in through]
            shares = np.cumsum([0.0, *lengths_m])
            s = arc_lengths(line)
            cuts = shares / shares[-1] * s[-1]
            for one, first, last in zip(through, cuts, cuts[1:]):
                lines[one] = _points(part_of(line, s, first, last))


def _ends_m(lane: Any, own: OpenDriveLanes, road: str, number: str) -> list[float]:
    """Return where a lane outside junctions begins and ends along its road in OpenDRIVE [m]."""
    nodes = lane.getEdge().getFromNode(), lane.getEdge().getToNode()
    ends_m = (own.length_m(road), 0.0) if int(number) > 0 else (0.0, own.length_m(road))
    return sorted(
        # netconvert splits a road at nodes of its name.
        own.place_m(road, *node.getCoord()[:2]) if node.getID().rpartition("#")[0] == road else end
        for node, end in zip(nodes, ends_m)
    )


def _origin(lane: Any) -> tuple[str, str]:
    """Return ids of road and lane in OpenDRIVE, both "" if it has none or several."""
    origins = (lane.getParam("origId") or "").split()
    road, _, number = origins[0].rpartition("_") if len(origins) == 1 else ("", "", "")
    return road, number


def _through(connection: Any, leads: dict[str, list[str]]) -> Iterator[str]:
    """Return the lanes in the junction that a connection leads over."""
    lane = connection.getViaLaneID()
    while lane and lane[0] == ":":
        yield lane
        lane = next(iter(leads[lane]), "")


@lru_cache(maxsize=1)
def _ways_cross(node: Any) -> bool:
    """Return whether ways cross in a junction; where they only part and meet, its lines count."""
    links = ((link.getToLane(), node.getLinkIndex(link)) for link in node.getConnections())
    ways = [(lane, number) for lane, number in links if number >= 0]
    return node.hasFoes() and any(
        lane != other and node.areFoes(number, index)
        for (lane, number), (other, index) in itertools.permutations(ways, 2)
    )


def _lane(
    lane: Any,
    lines: dict[str, np.ndarray],
    own: OpenDriveLanes | None,
    leads: list[str],
    comes: list[str],
) -> RoadLane:
    edge, points_m = lane.getEdge(), lines[lane.getID()]
    internal = edge.getFunction() == "internal"
    left, right = ("" if internal else _neighbour(lane, step, lines) for step in (1, -1))
    markings, limit_mps = (NONE, NONE), lane.getSpeed()
    roads = [one.rpartition("_") for one in (lane.getParam("origId") or "").split()]
    if own is not None and roads:
        limits = [one for road, _, name in roads for one in own.limits_mps.get((road, name), ())]
        if not internal or not _ways_cross(edge.getFromNode()):
            road, _, number = roads[0]
            markings = own.beside(road, number, *_ends_m(lane, own, road, number))
        if not internal:
            # netconvert writes four decimals.
            limit_mps = next((one for one in limits if abs(one - limit_mps) < 1e-3), limit_mps)
        else:
            # In a junction, netconvert knows the limits before and after it alone.
            limit_mps = min([limit_mps, *limits])
    elif not internal:
        twins = [
            one for one in edge.getToNode().getOutgoing() if one.getToNode() == edge.getFromNode()
        ]
        both = [_kind(each) for one in (edge, *twins) for each in one.getLanes()]
        single = both.count(DRIVING) == len(twins) + 1
        middle = SOLID if not twins else BROKEN if single else DOUBLE
        markings = (BROKEN if left else middle, BROKEN if right else SOLID)
    return RoadLane(
        lane.getID(),
        points_m[:, :2],
        lane.getWidth(),
        float(limit_mps),
        *markings,
        tuple(comes),
        tuple(leads),
        "" if markings[0] in _UNCROSSED else left,
        "" if markings[1] in _UNCROSSED else right,
        _kind(lane),
        edge.getFromNode().getID() if internal else "",
        points_m[:, 2],
    )


def _kind(lane: Any) -> str:
    """Return who drives on a lane. Cars do not where the limit, also behind a junction, is low."""
    internal = lane.getEdge().getFunction() == "internal"
    ends = [way.getToLane() for way in lane.getOutgoing()] if internal else [lane]
    is_slow = any(end.getSpeed() < _SLOWEST_MPS for end in ends if end.getID()[0] != ":")
    for word, kind in (("passenger", DRIVING), ("bicycle", BICYCLE), ("pedestrian", WALKING)):
        if lane.allows(word) and not (is_slow and kind == DRIVING):
            return kind
    return OTHER


def _junction(net: Any, node: Any, leads: dict[str, list[str]]) -> Junction:
    found = [
        connection
        for edge in node.getIncoming()
        for lane in edge.getLanes()
        for connection in lane.getOutgoing()
        if edge.getFunction() == "" and connection.getToLane().getID() in leads
    ]
    # The number of a link is searched once, and not for each pair of links.
    links = [node.getLinkIndex(one) if node.hasFoes() else -1 for one in found]
    # A stop sign is for a whole lane, also for a way from it that meets no other way.
    stops = {one.getFromLane() for one in found if _LINES.get(one.getState()) == STOP}
    connections = []
    for connection, link in zip(found, links):
        first = node._prohibits[link][::-1] if link >= 0 else ""
        others = [i for i, one in enumerate(links) if 0 <= one < len(first) and first[one] == "1"]
        light = connection.getTLLinkIndex() if connection.getTLSID() else -1
        line = _LINES.get(connection.getState(), "")
        if light >= 0 or connection.getFromLane() in stops:
            line = STOP
        if len(found) < 2:
            line = ""
        connections.append(
            Connection(
                connection.getFromLane().getID(),
                tuple(_through(connection, leads)),
                connection.getToLane().getID(),
                connection.getDirection(),
                tuple(others),
                light,
                line,
            )
        )
    name = node.getTLSID()
    programs = list(net.getTLSSecure(name).getPrograms().values()) if name else []
    phases = [(float(one.duration), one.state) for each in programs[:1] for one in each.getPhases()]
    polygon = np.array(node.getShape() or [node.getCoord()], float)[:, :2]
    return Junction(
        node.getID(),
        node.getType(),
        polygon,
        tuple(connections),
        tuple(phases),
        # What follows the traffic in SUMO begins with its first phase.
        float(programs[0]._offset) if programs and programs[0]._type == "static" else 0.0,
    )


def _polygons(net_path: str) -> Iterator[np.ndarray]:
    """Read the crosswalks among the objects of an OpenDRIVE file, which are beside its network."""
    path = os.path.join(os.path.dirname(net_path), POLYGONS)
    if os.path.exists(path):
        for one in ElementTree.parse(path).getroot().iter("poly"):
            if (one.get("type") or "").lower() == "crosswalk":
                points = [point.split(",")[:2] for point in (one.get("shape") or "").split()]
                yield np.array(points, float)


def main() -> None:
    """Print what a map contains, as rosrun sdc_map check.py does."""
    sys.exit(importlib.import_module("sdc_map.map_report").main())


if __name__ == "__main__":
    main()
