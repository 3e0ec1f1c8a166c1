"""Read a network from OpenDRIVE (.xodr) or from SUMO's network (.net.xml).

SUMO's `netconvert` reads OpenDRIVE, and its Python package `sumolib` reads what it writes;
docker/prepare maps installs both. What netconvert writes is kept in a cache by the content of the
map, and `opendrive_lanes` reads what netconvert does not. A map with elevation is read as if it
were flat.

python3 -m sdc_map.network_file MAP [--lanes] prints a summary, and the lanes.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from functools import lru_cache
from typing import Any, Iterator
from xml.sax import SAXException

import numpy as np
from scipy.spatial import cKDTree

from sdc_common.geometry.road_line import arc_lengths
from sdc_common.validation import DocumentError
from sdc_map.drivable import without_bends
from sdc_map.joints import joint
from sdc_map.map_file import map_file
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
from sdc_map.opendrive_file import read_opendrive
from sdc_map.opendrive_lanes import OpenDriveLanes
from sdc_map.yellow import lengthen_yellow

VERSION = "1.28.0"
_INSTALL = "run docker/prepare maps, which installs it and needs a connection"
# With these, centre lines are within 5 cm of the lanes of OpenDRIVE, in junctions within 20 cm.
# `--opendrive.lane-shapes` would move lanes beside a median by metres.
OPTIONS = (
    *("--opendrive.curve-resolution", "0.5", "--opendrive.advance-stopline", "0"),
    *("--opendrive.internal-shapes", "--offset.disable-normalization", "--no-turnarounds"),
    *("--output.original-names", "--precision", "4"),
)
# At most so much time [s] and memory [kB] for netconvert: some files make it take all there is.
TIMEOUT_S = 60.0
MEMORY_KB = 2_000_000
_FIX = "check the file, for example with asam-qc-opendrive, or read a part of it"
_ELEVATION_M = 0.05
# Lanes with a lower limit, such as those of car parks in SUMO, are not for cars.
_SLOWEST_MPS = 2.0
# netconvert's line of a lane, on which traffic drives, is beside that of the file by more [m].
_BESIDE_M = 0.5
_BESIDE = f"lanes whose line in netconvert, that of traffic, is over {_BESIDE_M} m beside"
_REFUSED = "bends that no car can drive"
_UNCROSSED = (SOLID, DOUBLE, KERB)
# By the letter of SUMO's connections: those that must stop or give way.
_LINES = {"s": STOP, "w": STOP, "m": YIELD}


class MapError(DocumentError):
    """A map that cannot be used; the one-line message names file, problem and fix."""


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


def network_path(path: str) -> str:
    """Return the path of SUMO's network of a map.

    Raises:
        MapError: netconvert cannot make it
    """
    path = map_file(path)
    return os.path.join(_converted(path), "map.net.xml") if _is_opendrive(path) else path


def _is_opendrive(path: str) -> bool:
    return path.lower().endswith(".xodr")


@lru_cache(maxsize=2)
def _loaded(path: str, _: int) -> Network:
    name, is_opendrive = os.path.basename(path).partition(".")[0], _is_opendrive(path)
    if not (is_opendrive or path.lower().endswith((".net.xml", ".net.xml.gz"))):
        raise MapError(
            f"{path}: is neither .xodr of OpenDRIVE nor .net.xml of SUMO; see docs/maps.md"
        )
    root, left_out = _tree(path) if is_opendrive else (None, [])
    try:
        own = None if root is None else OpenDriveLanes(root)
    except (LookupError, ValueError) as error:
        raise MapError(f"{path}: is not valid OpenDRIVE ({error!r})") from None
    file = network_path(path)
    try:
        from sumolib.net import readNet
    except ImportError:
        raise MapError(f"{path}: the Python package sumolib is missing; {_INSTALL}") from None
    try:
        net = readNet(file, withInternal=True, withPrograms=True, withPedestrianConnections=True)
        polygons = os.path.join(os.path.dirname(file), "map.poly.xml")
        crosswalks = list(_polygons(polygons)) if own else []
        places = re.sub(r"(?i)\.net\.xml(\.gz)?$", ".add.xml", path)
        network = _network(name, net, own, crosswalks, "" if own else places)
    except (SAXException, ValueError, LookupError, AttributeError) as error:
        raise MapError(f"{path}: is no complete network of SUMO ({error!r})") from None
    network.left_out = (*left_out, *network.left_out)
    return network


def _netconvert() -> str:
    """Return the path of netconvert, which is installed beside sumolib."""
    sumolib = importlib.util.find_spec("sumolib")
    folder = os.path.dirname(os.path.dirname((sumolib and sumolib.origin) or ""))
    path = os.path.join(folder, "sumo", "bin", "netconvert")
    if not os.access(path, os.X_OK):
        raise MapError(f"netconvert {VERSION}, which reads OpenDRIVE, is missing; {_INSTALL}")
    return path


def _tree(path: str) -> tuple[ElementTree.Element, list[str]]:
    """Return the tree of an OpenDRIVE file for netconvert, and what is left out of it."""
    try:
        return read_opendrive(path)
    except (ElementTree.ParseError, LookupError) as error:
        raise MapError(f"{path}: is not valid OpenDRIVE ({error!r})") from None
    except ValueError as error:
        raise MapError(f"{path}: {error}") from None


def _converted(path: str) -> str:
    """Return the folder of the cache with what netconvert makes of an OpenDRIVE file."""
    content = ElementTree.tostring(_tree(path)[0])
    key = hashlib.sha256(
        "\n".join((VERSION, *OPTIONS, "yellow", "")).encode() + content
    ).hexdigest()[:32]
    root = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    folder = os.path.join(root, "sdc_maps", key)
    if os.path.isdir(folder):
        return folder
    program = _netconvert()
    os.makedirs(os.path.dirname(folder), exist_ok=True)
    # A drive that is interrupted, or another one at the same time, leaves no half of a map.
    with tempfile.TemporaryDirectory(dir=os.path.dirname(folder)) as place:
        source, made = os.path.join(place, "map.xodr"), os.path.join(place, "made")
        with open(source, "wb") as file:
            file.write(content)
        os.mkdir(made)
        files = [os.path.join(made, name) for name in ("map.net.xml", "map.poly.xml")]
        command = [program, "--opendrive-files", source, "-o", files[0], "--polygon-output"]
        command += [files[1], *OPTIONS]
        # The data of another version of SUMO, or of libsumo in this process, are not its own.
        own = {name: value for name, value in os.environ.items() if name != "SUMO_HOME"}
        try:
            done = subprocess.run(
                ["/bin/sh", "-c", f'ulimit -v {MEMORY_KB}; exec "$@"', "sh", *command],
                capture_output=True,
                text=True,
                check=False,
                env=own,
                timeout=TIMEOUT_S,
            )
        except subprocess.TimeoutExpired:
            raise MapError(f"{path}: netconvert takes more than {TIMEOUT_S:g} s; {_FIX}") from None
        if done.returncode or not os.path.exists(files[0]):
            raise MapError(f"{path}: netconvert cannot read it: {_reason(done.stderr)}; {_FIX}")
        lengthen_yellow(files[0])
        try:
            os.rename(made, folder)
        except OSError:
            if not os.path.isdir(folder):
                shutil.copytree(made, folder)
    return folder


def _reason(text: str) -> str:
    """Return in one line why netconvert ended, by what it wrote to the standard error."""
    if "bad_alloc" in text:
        return f"it needs more than {MEMORY_KB / 1e6:g} GB"
    errors = [line[7:] for line in text.splitlines() if line.startswith("Error: ")]
    lines = list(dict.fromkeys(errors or text.splitlines())) or ["it ended without a reason"]
    return lines[0].rstrip(".") + (f" (and {len(lines) - 1} more)" if lines[1:] else "")


def _network(
    name: str, net: Any, own: OpenDriveLanes | None, crosswalks: list, places: str
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
    lines = {name: _points(lane.getShape()) for name, lane in sources.items()}
    found = {_BESIDE: [] if own is None else _take_lines_of_file(lines, sources, own, leads)}
    lanes = [_lane(lane, lines[one], own, leads[one], comes[one]) for one, lane in sources.items()]
    lanes, found[_REFUSED] = without_bends(lanes)
    for edge in net.getEdges():
        for lane in edge.getLanes() if edge.getFunction() == "crossing" else ():
            line = RoadLane("", _points(lane.getShape()), lane.getWidth(), 0.0)
            sides = line.beside(0.5 * line.width_m), line.beside(-0.5 * line.width_m)[::-1]
            crosswalks.append(np.vstack(sides))
    junctions = [_junction(net, node, leads) for node in net.getNodes()]
    heights = [point[2] for lane in sources.values() for point in lane.getShape3D()]
    is_flat = not heights or max(heights) - min(heights) < _ELEVATION_M
    bays, stops = _places(places, {lane.id: lane for lane in lanes})
    network = Network(name, lanes, junctions, crosswalks, is_flat, bays, stops)
    network.left_out = tuple(
        f"{what} ({len(texts)}, the first: {texts[0]})" for what, texts in found.items() if texts
    )
    return network


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
    points = np.array(shape, float)[:, :2]
    apart = np.append(True, np.hypot(*np.diff(points, axis=0).T) > 1e-3)
    apart[-1] |= apart.sum() < 2
    return points[apart]


def _take_lines_of_file(
    lines: dict[str, np.ndarray], sources: dict, own: OpenDriveLanes, leads: dict[str, list[str]]
) -> list[str]:
    """Replace the centre lines of netconvert by those of OpenDRIVE, and return where both differ.

    netconvert cuts roads where its junctions begin, which overlap where a road is short, and gives
    a lane one width. A road has its whole length here, and lanes in junctions join both ends.
    """
    beside = []
    outside = {name: lane for name, lane in sources.items() if name[0] != ":"}
    for name, lane in outside.items():
        road, number = _origin(lane)
        if road:
            line = own.line(road, number, *_ends_m(lane, own, road, number))
            if line is None:
                continue
            distances_m = cKDTree(line).query(lines[name])[0]
            if distances_m.max() > _BESIDE_M:
                x, y = lines[name][np.argmax(distances_m)]
                beside.append((-distances_m.max(), f"{name} at ({x:.0f}, {y:.0f})"))
            lines[name] = _points(line)
    for name, lane in outside.items():
        for connection in lane.getOutgoing():
            end = connection.getToLane().getID()
            through = list(_through(connection, leads))
            if end not in lines or not through:
                continue
            choices = own.through(*_origin(sources[through[0]])), [lines[one] for one in through]
            found = [np.vstack(line) for line in choices if line is not None]
            line = joint(lines[name], lines[end], found)
            shares = np.cumsum([0.0, *(arc_lengths(lines[one])[-1] for one in through)])
            s = arc_lengths(line)
            cuts = shares / max(shares[-1], 1e-9) * s[-1]
            for one, first, last in zip(through, cuts, cuts[1:]):
                lines[one] = _points(part_of(line, s, first, last))
    return [f"{text} by {-distance_m:.1f} m" for distance_m, text in sorted(beside)]


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


def _lane(
    lane: Any,
    points_m: np.ndarray,
    own: OpenDriveLanes | None,
    leads: list[str],
    comes: list[str],
) -> RoadLane:
    edge, index = lane.getEdge(), lane.getIndex()
    lanes = edge.getLanes()
    internal = edge.getFunction() == "internal"
    kinds = [_kind(one) for one in lanes]
    right = lanes[index - 1].getID() if index > 0 and kinds[index - 1] == kinds[index] else ""
    is_leftmost = index + 1 >= len(lanes) or kinds[index + 1] != kinds[index]
    left = "" if is_leftmost else lanes[index + 1].getID()
    markings, limit_mps = (NONE, NONE), lane.getSpeed()
    roads = [one.rpartition("_") for one in (lane.getParam("origId") or "").split()]
    if own is not None and roads:
        limits = [one for road, _, name in roads for one in own.limits_mps.get((road, name), ())]
        if not internal:
            road, _, number = roads[0]
            markings = own.beside(road, number, *_ends_m(lane, own, road, number))
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
        markings = (middle if is_leftmost else BROKEN, BROKEN if right else SOLID)
    own_junction = edge.getFromNode().getID() if internal else ""
    return RoadLane(
        lane.getID(),
        points_m,
        lane.getWidth(),
        float(limit_mps),
        *markings,
        tuple(comes),
        tuple(leads),
        "" if internal or markings[0] in _UNCROSSED else left,
        "" if internal or markings[1] in _UNCROSSED else right,
        kinds[index],
        own_junction,
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
    connections, has_foes = [], node.hasFoes()
    for connection in found:
        others = [i for i, one in enumerate(found) if has_foes and node.forbids(one, connection)]
        light = connection.getTLLinkIndex() if connection.getTLSID() else -1
        line = STOP if light >= 0 else _LINES.get(connection.getState(), "")
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


def _polygons(path: str) -> Iterator[np.ndarray]:
    """Read the crosswalks among the objects of an OpenDRIVE file."""
    if os.path.exists(path):
        for one in ElementTree.parse(path).getroot().iter("poly"):
            if (one.get("type") or "").lower() == "crosswalk":
                points = [point.split(",")[:2] for point in (one.get("shape") or "").split()]
                yield np.array(points, float)


def main() -> None:
    """Print what a map contains."""
    if len(sys.argv) < 2 or sys.argv[2:] not in ([], ["--lanes"]):
        sys.exit("Usage: python3 -m sdc_map.network_file MAP [--lanes]")
    try:
        network = load_network(sys.argv[1])
    except MapError as error:
        sys.exit(f"network_file: {error}")
    length_m = sum(lane.length_m for lane in network.driving)
    kinds = [one.kind for one in network.junctions.values() if len(one.connections) > 2]
    print(
        f"{network.name}: {len(network.driving)} lanes for cars, {length_m / 1000:.1f} km, "
        f"{len(kinds)} junctions, {kinds.count('traffic_light')} with lights, "
        f"{len(network.crosswalks)} crosswalks" + ("" if network.is_flat else "; driven flat")
    )
    for text in network.left_out:
        print(f"left out: {text}")
    for lane in network.driving if sys.argv[2:] else ():
        if not lane.junction:
            (x, y), (end_x, end_y) = lane.points_m[[0, -1]]
            print(f"{lane.id}: ({x:.1f}, {y:.1f}) to ({end_x:.1f}, {end_y:.1f})")


if __name__ == "__main__":
    main()
