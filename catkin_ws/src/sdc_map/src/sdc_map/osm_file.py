"""Read the streets of OpenStreetMap that cars drive on, in the form that netconvert reads."""

from __future__ import annotations

import heapq
import math
import re
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from pathlib import Path
from typing import Collection, Iterator, Mapping

import numpy as np

from sdc_map.findings import Findings
from sdc_map.map_file import packaged_maps
from sdc_map.mirror import mirrored_tags
from sdc_map.osm_side import Tagged, traffic_side

# Streets for cars in SUMO's XML: lanes in a direction and limit where the file has none, and rank.
_TYPES = Path(packaged_maps(), "osm.typ.xml").read_bytes()
# Their limits by the value of `highway` [km/h].
_STREETS = {
    kind.attrib["id"].rpartition(".")[2]: round(3.6 * float(kind.attrib["speed"]))
    for kind in ElementTree.fromstring(_TYPES)
}
# Keys that say who may drive on a street, the most special one first, and what closes it for cars.
_ACCESS = ("motorcar", "motor_vehicle", "vehicle", "access")
_CLOSED = ("no", "private", "agricultural", "forestry", "emergency", "psv", "bus")
# Values of `service` of ways to a single house or place.
_DRIVEWAYS = ("driveway", "drive-through", "emergency_access")
# Limits that netconvert reads, and those of zones [km/h] by the last part of values like DE:urban.
_LIMITS = ("maxspeed", "maxspeed:forward", "maxspeed:backward")
_LANES = ("lanes", "lanes:forward", "lanes:backward")
_NUMBER = re.compile(r"(?=.*[1-9])\d+(\.\d+)?( ?(mph|km/h))?")
# A limit with its country, such as DE:zone30 and FR:50.
_OF_COUNTRY = re.compile(r"[A-Z]{2}:(zone:?)?(?=\d)")
_ZONES = {"urban": 50, "rural": 100, "motorway": 130, "none": 130, "living_street": 10, "walk": 10}
# Keys by whose values ways, and nodes of streets, are named where the map does not have them.
_WAY_KEYS = ("highway", "railway", "aeroway")
_NODE_KEYS = ("highway", "railway", "barrier", "traffic_calming", "traffic_sign")
_READ = ("traffic_signals", "turning_circle", "turning_loop", "motorway_junction", "street_lamp")
_NO_BARRIER = ("kerb", "entrance", "border_control")
# A light belongs to a crossing at most so far along the street [m].
_LIGHT_M = 40.0
# Greatest size of a map.
_LARGEST_DEGREES = 1.0
# A degree of latitude.
_DEGREE_M = 111_200.0


def read_osm(root: ElementTree.Element, findings: Findings) -> tuple[dict[str, bytes], str, bool]:
    """Read the streets for cars of a file; what is left out is added to the findings.

    Streets with traffic on the left are mirrored to the other side of the equator.

    Returns:
        the files that netconvert reads by their names, its option that gives x and y around the
        middle of the streets, and whether traffic is on the left

    Raises:
        ValueError: it has no street for cars
    """
    elements = [
        element for element in root if element.get("action") != "delete"
    ]  # by the editor JOSM
    nodes = {element.get("id", ""): element for element in elements if element.tag == "node"}
    tagged = [(element, _tags(element)) for element in elements]
    ways = [(element, tags) for element, tags in tagged if element.tag == "way"]
    streets = [(way, tags) for way, tags in ways if _is_for_cars(tags)]
    on_streets = dict.fromkeys(name for way, _ in streets for name in _refs(way))
    places = {name: place for name, node in nodes.items() if (place := _place(node)) is not None}
    used = [name for name in on_streets if name in places]
    if not used:
        raise ValueError(_without_streets(tagged, bool(streets)))
    is_left, findings.side = traffic_side(tagged, streets, places)
    if is_left:
        places = {name: place * (-1.0, 1.0) for name, place in places.items()}
    ends = [choose([places[name] for name in used], axis=0) for choose in (np.min, np.max)]
    if np.ptp(ends, axis=0).max() > _LARGEST_DEGREES:
        raise ValueError("has streets that are farther than 100 km apart; export a smaller area")
    middle = np.mean(ends, axis=0).round(4)
    scale = _DEGREE_M * np.array([1.0, math.cos(math.radians(middle[0]))])
    points_m = {
        name: tuple(((place - middle) * scale)[::-1].tolist()) for name, place in places.items()
    }
    kept = ElementTree.Element("osm", version="0.6")
    lights = _lights(streets, nodes, points_m)
    crossings = {*lights.values()}
    for name in used:
        lat, lon = places[name].tolist()
        node = ElementTree.SubElement(kept, "node", id=name, lat=repr(lat), lon=repr(lon))
        if name in crossings:
            ElementTree.SubElement(node, "tag", k="highway", v="traffic_signals")
    for name in on_streets:
        kinds = [*_of_node(nodes.get(name), name in places)]
        kinds += ["lights that are at no junction"] if lights.get(name) == "" else []
        for kind in kinds:
            findings.add(kind, f"node {name}", point_m=points_m.get(name))
    for way, tags in ways:
        point_m = next((points_m[name] for name in _refs(way) if name in points_m), None)
        for kind in _of_way(tags, "left" if is_left else "right"):
            findings.add(kind, f"way {way.get('id')}", point_m=point_m)
    kept.extend(_written(way, tags, points_m.keys(), is_left) for way, tags in streets)
    kept.extend(
        element
        for element, tags in tagged
        if element.tag == "relation" and tags.get("type") == "restriction"
    )
    projection = "--proj=+proj=tmerc +ellps=WGS84 +units=m +lat_0={} +lon_0={}".format(*middle)
    return {"map.osm": ElementTree.tostring(kept), "types.xml": _TYPES}, projection, is_left


def _without_streets(tagged: Tagged, are_streets: bool) -> str:
    """Return what is wrong with a file without a street for cars that has a place."""
    if any(tags.get("type") == "lanelet" for _, tags in tagged):
        return "is a map of Lanelet2, which is not read; convert it to OpenDRIVE"
    ways = (tags for element, tags in tagged if element.tag == "way")
    kinds = sorted({tags["highway"] for tags in ways if "highway" in tags})
    text = f"only {', '.join(kinds[:5])}" if kinds else "no way with the key highway"
    text = "of which the file has a valid place" if are_streets else text
    return f"has no street for cars, {text}; export an area with streets"


def _tags(element: ElementTree.Element) -> dict[str, str]:
    return {tag.get("k", ""): tag.get("v", "") for tag in element.findall("tag")}


def _refs(way: ElementTree.Element) -> list[str]:
    return [nd.get("ref", "") for nd in way.findall("nd")]


def _place(node: ElementTree.Element) -> np.ndarray | None:
    """Return latitude and longitude of a node, None if streets cannot be there."""
    try:
        place = np.array([float(node.get(key, "nan")) for key in ("lat", "lon")])
    except ValueError:
        return None
    return place if (np.abs(place) < (85.0, 180.0)).all() else None


def _is_for_cars(tags: dict[str, str]) -> bool:
    access = next((tags[key] for key in _ACCESS if key in tags), "yes")
    is_street = tags.get("highway") in _STREETS and tags.get("area") != "yes"
    return is_street and access not in _CLOSED and tags.get("service") not in _DRIVEWAYS


def _lights(
    streets: list[tuple[ElementTree.Element, dict[str, str]]],
    nodes: dict[str, ElementTree.Element],
    points_m: Mapping[str, tuple[float, ...]],
) -> dict[str, str]:
    """Return the crossing of streets of each light, which may be before it, "" if there is none."""
    beside: dict[str, set[str]] = defaultdict(set)
    for way, tags in streets:
        names = [name for name in _refs(way) if name in points_m]
        for name, other in zip(names, names[1:]) if tags["highway"] != "service" else ():
            beside[name].add(other)
            beside[other].add(name)
    signals = (name for name in beside if _tags(nodes[name]).get("highway") == "traffic_signals")
    return {name: _crossing(name, beside, points_m) for name in signals}


def _crossing(
    light: str, beside: dict[str, set[str]], points_m: Mapping[str, tuple[float, ...]]
) -> str:
    queue, seen = [(0.0, light)], set()
    while queue:
        along_m, name = heapq.heappop(queue)
        if len(beside[name]) > 2:
            return name
        seen.add(name)
        for other in beside[name] - seen:
            other_m = along_m + math.dist(points_m[name], points_m[other])
            if other_m < _LIGHT_M:
                heapq.heappush(queue, (other_m, other))
    return ""


def _of_node(node: ElementTree.Element | None, has_place: bool) -> Iterator[str]:
    """Yield what the map does not have of a node of a street."""
    if node is None or not has_place:
        yield "nodes that the file lacks" if node is None else "nodes without a valid place"
        return
    tags = _tags(node)
    for key in _NODE_KEYS:
        if tags.get(key, "no") not in ("no", *_READ, *_NO_BARRIER):
            yield f"points of streets with {key}={tags[key]}"


def _of_way(tags: dict[str, str], side: str) -> Iterator[str]:
    """Yield what the map with traffic on this side does not have of a way, or has otherwise."""
    if not _is_for_cars(tags):
        closed = ", closed to cars" if tags.get("highway") in _STREETS else ""
        closed = ", driveways" if tags.get("service") in _DRIVEWAYS else closed
        yield from (f"ways with {key}={tags[key]}{closed}" for key in _WAY_KEYS if key in tags)
        return
    limits = [tags[key] for key in _LIMITS if key in tags]
    if not limits:
        limit_kmh = _STREETS[tags["highway"]]
        yield f"ways with highway={tags['highway']} without a limit, read as {limit_kmh} km/h"
    yield from (
        f"limits of the kind {value}, not read" for value in limits if _limit(value) is None
    )
    yield from (f"{key}={tags[key]}, not read" for key in tags if _is_wrong(key, tags[key]))
    if "lanes:both_ways" in tags:
        yield "ways with lanes:both_ways, not for cars"
    if tags.get("driving_side", side) != side:
        yield f"ways with driving_side={tags['driving_side']}, not read"
    for key in ("bridge", "tunnel"):
        if tags.get(key, "no") != "no":
            yield f"ways with {key}={tags[key]}, which are flat in the map"


def _is_wrong(key: str, value: str) -> bool:
    """Return whether netconvert would not end with a number of lanes, or a width is no street's."""
    is_count = key in _LANES and not re.fullmatch(r"[1-9]|1\d", value)
    is_width = key == "width" and not re.fullmatch(r"([2-9]|\d\d+)(\.\d+)?( ?m)?", value)
    return is_count or is_width


def _limit(value: str) -> str | None:
    """Return a limit in the form that netconvert reads, None if it has none."""
    value = _OF_COUNTRY.sub("", value)
    zone = _ZONES.get(value.rpartition(":")[2])
    return value if _NUMBER.fullmatch(value) else str(zone) if zone else None


def _written(
    way: ElementTree.Element, tags: dict[str, str], places: Collection[str], is_left: bool
) -> ElementTree.Element:
    """Return a street with the nodes and limits that netconvert reads."""
    written = ElementTree.Element("way", id=way.get("id", ""))
    nodes = (ElementTree.Element("nd", ref=name) for name in _refs(way) if name in places)
    written.extend(nodes)
    for key, value in (mirrored_tags(tags) if is_left else tags).items():
        if key == "lanes" and "lanes:both_ways" in tags and value.isdigit():
            value = str(int(value) - 1)
        limit = _limit(value) if key in _LIMITS else value
        if limit is not None and not (key in _ACCESS or _is_wrong(key, value)):
            ElementTree.SubElement(written, "tag", k=key, v=limit)
    return written
