"""Make SUMO's network of a map with `netconvert`, and keep it by the content of the map."""

from __future__ import annotations

import codecs
import gzip
import os
import re
import xml.etree.ElementTree as ElementTree
import zlib
from dataclasses import dataclass, replace

import numpy as np

from sdc_common.geometry.road_line import arc_lengths
from sdc_map.findings import Findings
from sdc_map.mirror import move_net
from sdc_map.opendrive_file import read_opendrive, road_between_junctions, shift_to_origin
from sdc_map.opendrive_lanes import OpenDriveLanes
from sdc_map.osm_file import read_osm
from sdc_map.sumo_programs import MapError, cached, lengthen_yellow, run

# File with objects of OpenDRIVE beside SUMO's network.
POLYGONS = "map.poly.xml"
_OPTIONS = ("--no-turnarounds", "--offset.disable-normalization", "--precision", "4")
# With these, centre lines are within 5 cm of the lanes of OpenDRIVE, in junctions within 20 cm.
# `--opendrive.lane-shapes` would move lanes beside a median by metres.
_OPENDRIVE = (
    *("--opendrive-files=../map.xodr", f"--polygon-output={POLYGONS}"),
    *("--opendrive.curve-resolution", "0.5", "--opendrive.advance-stopline", "0"),
    *("--opendrive.internal-shapes", "--output.original-names"),
    # A light of a junction is also named by the roads near it: no light where two of them meet.
    *("--tls.discard-simple", "true"),
)
# `--osm.crossings` ends with a segmentation fault on most towns.
_OSM = (
    *("--osm-files=../map.osm", "--type-files=../types.xml"),
    *("--geometry.remove", "--ramps.guess", "--junctions.join", "--xml-validation", "never"),
    *("--osm.sidewalks", "--osm.turn-lanes", "--osm.lane-access"),
    # Joined lights have many phases: with the usual 31 s for each, a car would wait for minutes.
    *("--tls.join", "--tls.green.time", "10"),
    # Streets in towns have sidewalks: those with a limit of at most 60 km/h. Without them,
    # pedestrians would walk on the lanes for cars of slow streets, and over their mouths.
    *("--sidewalks.guess", "--sidewalks.guess.min-speed", "2", "--sidewalks.guess.max-speed", "17"),
    "--crossings.guess",
)
# Larger files take more than that in Python.
MOST_BYTES = 50_000_000
# Endings of the files that are read, by their first element.
_ENDINGS = {"OpenDRIVE": (".xodr",), "osm": (".osm", ".osm.xml"), "net": (".net.xml",)}
_FIXES = {
    "OpenDRIVE": "check the file, for example with asam-qc-opendrive, or read a part of it",
    "osm": "export a smaller area, or another one",
    "net": "make it again with netconvert",
}
# Name of SUMO's network in a folder of the cache.
_NET = "map.net.xml"


@dataclass
class MapSource:
    """The files of a map."""

    net_path: str  # SUMO's network
    findings: Findings
    is_mirror: bool  # whether traffic is on the left in the map, of which this is mirrored
    opendrive: OpenDriveLanes | None = None  # the lanes of OpenDRIVE, None for other maps


def map_source(path: str) -> MapSource:
    """Return the files of a map; netconvert makes a network of OpenDRIVE and OpenStreetMap.

    Raises:
        MapError: it cannot be read
    """
    name = re.sub(r"\.gz$", "", path.lower())
    tag = next((tag for tag, endings in _ENDINGS.items() if name.endswith(endings)), "")
    if not tag:
        fix = "name a .xodr of OpenDRIVE, an .osm of OpenStreetMap or a .net.xml of SUMO"
        if name.endswith(".pbf"):
            fix = "write it as XML: osmium cat FILE.osm.pbf -o FILE.osm"
        raise MapError(f"{path}: is no map by its ending; {fix}")
    root, findings, lanes, fix = _parsed(path, tag), Findings(), None, _FIXES[tag]
    options: tuple[str, ...] = _OPENDRIVE
    try:
        if tag == "net":
            if "mirrorOf" in root.attrib:
                named = os.path.join(os.path.dirname(path), root.attrib["mirrorOf"])
                return replace(map_source(named), is_mirror=True)
            net_path, is_left = _moved(path, root, findings)
            return MapSource(net_path, findings, is_left)
        if tag == "OpenDRIVE":
            is_left = read_opendrive(root, findings)
            if road := road_between_junctions(root):
                fix = f"{road}, which it may not read: write a road between them"
            files, lanes = {"map.xodr": ElementTree.tostring(root)}, OpenDriveLanes(root)
        else:
            files, projection, is_left = read_osm(root, findings)
            options = (*_OSM, projection)
    except LookupError as error:
        raise MapError(f"{path}: lacks a part ({error!r}); {fix}") from None
    except ValueError as error:
        raise MapError(f"{path}: {error}") from None
    net_path = _converted(path, files, options, fix)
    return MapSource(net_path, findings, is_left, lanes)


def _parsed(path: str, tag: str) -> ElementTree.Element:
    """Return the tree of an XML file whose first element has this tag, without namespaces."""
    with open(path, "rb") as file:
        is_packed = file.read(2) == b"\x1f\x8b"
    content = b""
    try:
        with gzip.open(path) if is_packed else open(path, "rb") as file:
            content = file.read(MOST_BYTES + 1)
        if len(content) > MOST_BYTES:
            most_mb = MOST_BYTES // 1_000_000
            raise MapError(f"{path}: has more than {most_mb} MB; read a smaller area")
        root = ElementTree.fromstring(_decoded(content))
    except MapError:
        raise
    except (ElementTree.ParseError, EOFError, LookupError, ValueError, zlib.error) as error:
        text, fix = f"is no XML: {error}", "download or export it again"
        if content.startswith(b"version https://git-lfs"):
            text, fix = "is a pointer of Git LFS to the map", "get it with `git lfs pull`"
        elif re.search(rb"<!doctype html|<html", content[:1000], re.IGNORECASE):
            text = "is a web page, and no map"
        elif not (content or is_packed):
            text = "is empty"
        raise MapError(f"{path}: {text}; {fix}") from None
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    if root.tag != tag:
        fix = "download or export it again"
        if root.tag in _ENDINGS:
            fix = f"name it with the ending {_ENDINGS[root.tag][0]}"
        raise MapError(f"{path}: its first element is {root.tag}, not {tag}; {fix}")
    return root


def _decoded(content: bytes) -> str:
    """Return the text of a file, in UTF-16 by its mark, or as it declares, else in UTF-8."""
    if content[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        return content.decode("utf-16")
    named = re.match(rb"<\?xml[^>]*encoding\s*=\s*.(?!utf)([\w.-]+)", content, re.IGNORECASE)
    # A letter in another encoding, as of the name of a street, must not refuse the map.
    return content.decode(named[1].decode() if named else "utf-8-sig", "replace")


def _moved(path: str, root: ElementTree.Element, findings: Findings) -> tuple[str, bool]:
    """Return the path of a network of SUMO, or of a copy that is mirrored or near the origin.

    Returns:
        the path, and whether it is mirrored
    """
    nodes = [node for node in root.iter("junction") if node.get("x")]
    places = np.array([[float(node.get(axis, "nan")) for axis in "xy"] for node in nodes])
    first = f"junction {nodes[0].get('id')}" if nodes else ""
    shift_m = shift_to_origin(places.reshape(-1, 2), findings, first)
    is_left = move_net(root, shift_m)
    projections = {location.get("projParameter", "!") for location in root.iter("location")}
    if not (findings.places or is_left or projections - {"!"}):
        return path, False
    folder = cached(ElementTree.tostring(root), lambda made: _write(root, made))
    return os.path.join(folder, _NET), is_left


def net_with_lines(path: str, lines_m: dict[str, np.ndarray]) -> str:
    """Return the path of a copy of a network in the cache with other lines of lanes, (N, 3) [m]."""

    def make(made: str) -> None:
        root = ElementTree.parse(path).getroot()
        for lane in root.iter("lane"):
            name = lane.get("id", "")
            if name in lines_m:
                line_m = lines_m[name]
                points = (f"{x:.2f},{y:.2f},{z:.2f}" for x, y, z in line_m.tolist())
                lane.set("shape", " ".join(points))
                if name[0] == ":":  # the lanes of an edge have one length in SUMO
                    lane.set("length", f"{arc_lengths(line_m[:, :2])[-1]:.2f}")
        _write(root, made)

    lines = (name.encode() + line_m.tobytes() for name, line_m in lines_m.items())
    return os.path.join(cached(path.encode() + b"".join(lines), make), _NET)


def _write(root: ElementTree.Element, folder: str) -> None:
    """Write a network into a folder; libsumo would look for data of projections."""
    for location in root.iter("location"):
        location.set("projParameter", "!")
    ElementTree.ElementTree(root).write(os.path.join(folder, _NET))


def _converted(path: str, files: dict[str, bytes], options: tuple[str, ...], fix: str) -> str:
    """Return the path in the cache of what netconvert makes of files, by their names."""
    options = (*options, *_OPTIONS)

    def make(made: str) -> None:
        for name, data in files.items():
            with open(os.path.join(os.path.dirname(made), name), "wb") as file:
                file.write(data)
        net_path = os.path.join(made, _NET)
        run("netconvert", [*options, f"--output-file={_NET}"], net_path, path, fix)
        root = ElementTree.parse(net_path).getroot()
        lengthen_yellow(root)
        _write(root, made)

    key = "\n".join((*options, "yellow", "")).encode() + b"".join(files.values())
    return os.path.join(cached(key, make), _NET)
