"""Read a file of OpenDRIVE, and write into it what netconvert would not read."""

from __future__ import annotations

import copy
import math
import re
import xml.etree.ElementTree as ElementTree
from typing import Any, Iterator

import numpy as np

from sdc_common.routes.csv_columns import is_number
from sdc_map.direct_junctions import write_connecting_roads
from sdc_map.findings import Findings
from sdc_map.mirror import mirror_left_hand
from sdc_map.opendrive_lanes import cubics, named_road, point_at, sections

_UNITS_MPS = {"mph": 0.44704, "km/h": 1.0 / 3.6, "m/s": 1.0}
# Limit of a motorway, and where the file has "no limit" [m/s]: 130 km/h, recommended in Germany.
_NO_LIMIT_MPS = 130.0 / 3.6
# Types of lanes on which cars do not drive, though some are lanes for cars in netconvert.
_NOT_DRIVEN = ("stop", "parking", "roadWorks", "bidirectional", "bus", "taxi", "HOV")
# The type as netconvert knows it.
_TYPES = {
    **dict.fromkeys(_NOT_DRIVEN, "shoulder"),
    **dict.fromkeys(("slipLane", "connectingRamp", "shared"), "driving"),
}
_FOR_CARS = ("driving", "entry", "exit", "onRamp", "offRamp", "mwyEntry", "mwyExit")
# Pieces of a cubic along a road: what they are in, their tag, and the key of their beginning.
_PIECES = (
    ("lanes", "laneOffset", "s"),
    ("elevationProfile", "elevation", "s"),
    ("lanes/laneSection/*/lane", "width", "sOffset"),
)
# What SUMO refuses in a name.
_NOT_IN_IDS = r"""[\s;|,<>&'"\\]|^:"""
# Attributes without which netconvert refuses the whole map.
_NEEDED = {"signal": ("id", "type", "s", "orientation", "dynamic"), "object": ("id", "s", "t")}
# Elements of a road whose parts are read, those that are read without their parts, and the first
# level of the file that is read.
_WHOLES = (
    *("link", "type", "planView", "geometry", "elevationProfile", "lateralProfile", "lanes"),
    *("laneSection", "left", "center", "right", "lane", "objects", "signals", "surface"),
)
_PARTS = (
    *("predecessor", "successor", "speed", "line", "spiral", "arc", "poly3", "paramPoly3"),
    *("elevation", "laneOffset", "width", "border", "roadMark", "access", "signalReference"),
    "userData",
)
_READ = ("header", "road", "junction", "controller", "junctionGroup", "userData")
# Elements of a road whose attributes are numbers, or words other than nan and inf.
_NUMBERS = ("planView", "elevationProfile", "lanes")
# Curvatures that differ by less are the same [1/m]: within 100 m, they are 0.2 mm apart.
_SAME_CURVATURE = 1e-7
# Positions that are farther from the origin are coordinates of the Earth [m].
FARTHEST_M = 100_000.0
# Limits and sections that begin so close to each other begin at one place.
_SAME_PLACE_M = 1.0


def read_opendrive(root: ElementTree.Element, findings: Findings) -> bool:
    """Bring the tree of a file into the form that netconvert reads; add what is left out.

    Each lane has its speed limits, those of the road, too, and a width instead of a border. The
    projection and the offset are left out: positions are those of the file, as CARLA uses them.

    Returns:
        whether traffic is on the left in the file: then the tree is mirrored

    Raises:
        LookupError, ValueError: it is not valid OpenDRIVE
    """
    _mend(root)
    _refuse(root)
    _move(root, findings)
    is_left = mirror_left_hand(root)
    for element in root:
        tag, kind = element.tag, element.get("type", "default")
        if tag not in _READ or kind not in ("default", "direct"):
            text = f"elements {tag}" if tag not in _READ else f"{tag}s of the type {kind}"
            findings.add(text, f"{tag} {element.get('id')}")
    for road in root.iter("road"):
        with named_road(road):
            _read_road(road, findings)
    _remove_open_links(root, findings)
    write_connecting_roads(root, findings)
    return is_left


def _mend(root: ElementTree.Element) -> None:
    """Remove the projection, and what no lane needs and netconvert would refuse."""
    for header in root.findall("header"):
        for element in [*header.findall("geoReference"), *header.findall("offset")]:
            header.remove(element)
        for name, usual in (("revMajor", "1"), ("revMinor", "4")):
            if not header.get(name, "").isdecimal():
                header.set(name, usual)
    for parent in [*root.iter()]:
        for one in parent.findall("validity"):
            if not {"fromLane", "toLane"} <= {*one.attrib}:
                parent.remove(one)


def _check_numbers(road: ElementTree.Element) -> None:
    """Raise ValueError for numbers with which netconvert would fail."""
    for element in (one for part in _NUMBERS for one in road.findall(part + "//*")):
        for name, value in element.attrib.items():
            is_negative = name == "length" and value[:1] == "-"
            if is_negative or value.strip("+-").lower() in ("nan", "inf"):
                raise ValueError(f"{name} of an element {element.tag} is {value}")


def _read_road(road: ElementTree.Element, findings: Findings) -> None:
    _check_numbers(road)
    _write_starts(road)
    _name_unread(road, findings)
    for section, start_m, _ in sections(road):
        # netconvert takes lanes to be in this order.
        for side in (*section.findall("left"), *section.findall("right")):
            side[:] = sorted(side, key=lambda lane: -int(lane.get("id", 0)))
        _write_widths(section)
        for lane in section.iter("lane"):
            kind = "none" if lane.get("id") == "0" else lane.get("type") or "missing"
            if lane.get("direction", "standard") != "standard":
                kind = "bidirectional"
            if lane.find("width") is None and lane.get("id") != "0":
                kind = "none"
                _add(findings, "lanes without a width", road, start_m)
            if kind in _NOT_DRIVEN or kind not in ("none", *_FOR_CARS, *_TYPES):
                _add(findings, f"lanes of the type {kind}", road, start_m)
            lane.set("type", _TYPES.get(kind, kind))
            _write_access(lane)
    _write_limits(road)
    _write_arcs(road)
    lanes = (lane for lane in road.iter("lane") if lane.get("id") != "0")
    driven = [lane for lane in lanes if lane.get("type") in _FOR_CARS]
    is_limited = all(lane.find("speed") is not None for lane in driven)
    if not is_limited and road.get("junction", "-1") == "-1":
        place = f"road {road.get('id')}", point_at(road, 0.0)
        findings.add("roads without a limit, read as 50 km/h", *place)


def _refuse(root: ElementTree.Element) -> None:
    """Raise ValueError for what is valid OpenDRIVE and cannot be driven."""
    names = [road.get("id", "") for road in root.iter("road")]
    if not names:
        files = ", ".join(one.get("file", "") for one in root.iter("include"))
        fix = f"write what is in {files} in the place of its include" if files else "add roads"
        raise ValueError(f"has no road; {fix}")
    for name in names if len(set(names)) < len(names) else ():
        if names.count(name) > 1:
            raise ValueError(f"{names.count(name)} roads have the id {name}; give each its own")
    for place in (*root.iter("road"), *root.iter("junction")):
        if not place.get("id"):
            raise ValueError(f"a {place.tag} has no id; give each one")
        if re.search(_NOT_IN_IDS, place.attrib["id"]):
            text = f"the id of {place.tag} {place.get('id')!r} has a blank or another mark"
            raise ValueError(f"{text} that SUMO refuses; write letters, digits, - and _ in it")
    for road in root.iter("road"):
        with named_road(road):
            if not 0.0 <= float(road.attrib["length"]) < FARTHEST_M:
                text = f"has the length {road.attrib['length']}, which must be from 0 to 100 km"
                raise ValueError(text)


def _move(root: ElementTree.Element, findings: Findings) -> None:
    """Move a map in coordinates of the Earth to the origin."""
    rows = [(road, piece) for road in root.iter("road") for piece in road.iter("geometry")]
    places = np.array([[float(piece.attrib[axis]) for axis in "xy"] for _, piece in rows])
    for (road, _), place in zip(rows, places):
        if not np.isfinite(place).all():
            raise ValueError(f"road {road.get('id')} is at {place.tolist()}; write numbers there")
    shift_m = shift_to_origin(places, findings, f"road {rows[0][0].get('id')}" if rows else "")
    for (_, piece), place in zip(rows, (places - shift_m).tolist() if any(shift_m) else ()):
        piece.attrib.update(zip("xy", map(repr, place)))


def shift_to_origin(places: np.ndarray, findings: Findings, first: str) -> np.ndarray:
    """Return the middle (2,) of places (N, 2) if they are coordinates of the Earth, else 0 [m].

    Args:
        places: the places [m]
        findings: that they are moved is added here
        first: where the first of them is in the file
    """
    if not len(places) or not np.abs(places).max() > FARTHEST_M:
        return np.zeros(2)
    middle = (0.5 * (places.min(axis=0) + places.max(axis=0))).round(-2)
    x_m, y_m = (0.0 - middle).tolist()
    findings.add(f"places, moved by ({x_m:.0f}, {y_m:.0f}) m", first)
    return middle


def _remove_open_links(root: ElementTree.Element, findings: Findings) -> None:
    """Remove links to roads, junctions and signals that the file does not have."""
    known = {
        (kind, one.get("id")) for kind in ("road", "junction", "signal") for one in root.iter(kind)
    }
    for road in root.iter("road"):
        if ("junction", road.get("junction")) not in known:
            road.set("junction", "-1")
        for signals in road.findall("signals"):
            for reference in signals.findall("signalReference"):
                if ("signal", reference.get("id")) not in known:
                    signals.remove(reference)
    for place in (*root.iter("road"), *root.iter("junction")):
        parents = [place] if place.tag == "junction" else place.findall("link")
        links = [(parent, link) for parent in parents for link in parent]
        for parent, link in links:
            targets = [(link.get("elementType"), link.get("elementId"))]
            if link.tag == "connection":
                through = link.get("connectingRoad", link.get("linkedRoad"))
                targets = [("road", link.get("incomingRoad")), ("road", through)]
            lost = [target for target in targets if target not in known]
            if lost and link.tag in ("connection", "predecessor", "successor"):
                text = f"{place.tag} {place.get('id')} to {lost[0][0]} {lost[0][1]}"
                findings.add("links to what the file does not have", text)
                parent.remove(link)


def _elements(parent: ElementTree.Element, s_m: float = 0.0) -> Iterator[tuple]:
    """Yield the elements of a road whose parents are read: parent, element and place [m]."""
    for element in list(parent):
        s = element.get("s", "")
        at_m = float(s) if is_number(s) else s_m + float(element.get("sOffset") or 0.0)
        yield parent, element, at_m
        if element.tag in _WHOLES:
            yield from _elements(element, at_m)


def _name_unread(road: ElementTree.Element, findings: Findings) -> None:
    """Add signs, objects and other parts of a road that the map does not have.

    Remove objects, and signals for which netconvert would refuse the whole map.
    """
    for parent, element, s_m in _elements(road):
        tag, kind = element.tag, element.get("type", "")
        values = {name: element.get(name, "") for name in _NEEDED.get(tag, ())}
        lacking = [
            name
            for name, value in values.items()
            if not value or name in ("s", "t") and not is_number(value)
        ]
        sizes = [element.get(name) for name in ("inner", "outer", *"abcd")]
        is_nothing = any(sizes) and not any(float(size or 0.0) for size in sizes)
        if lacking:
            place = f"{tag} {element.get('id')} of road {road.get('id')}"
            findings.add(f"{tag}s without {lacking[0]}", place, point_at(road, 0.0))
            parent.remove(element)
        elif tag == "signal":
            if element.get("dynamic") != "yes":
                _add(findings, f"signals of the type {kind}", road, s_m)
        elif tag == "object":
            if kind.lower() != "crosswalk":
                _add(findings, f"objects of the type {kind or 'none'}", road, s_m)
                parent.remove(element)
        elif tag not in (*_WHOLES, *_PARTS) and not is_nothing:
            _add(findings, f"elements {tag}", road, s_m)


def _add(findings: Findings, kind: str, road: ElementTree.Element, s_m: float) -> None:
    """Add a place along a road [m]."""
    findings.add(kind, f"road {road.get('id')} at {s_m:.0f} m", point_at(road, s_m))


def _write_starts(road: ElementTree.Element) -> None:
    """Write what applies before the first piece: no lane offset, and else the value of the piece.

    netconvert continues the first piece backwards.
    """
    for parents, tag, key in _PIECES:
        for parent in road.findall(parents):
            pieces = parent.findall(tag)
            first = min(pieces, key=lambda piece: float(piece.attrib[key]), default=None)
            if first is not None and float(first.attrib[key]) > _SAME_PLACE_M:
                value = "0" if tag == "laneOffset" else first.attrib["a"]
                zeros = dict.fromkeys("bcd", "0")
                start = ElementTree.Element(tag, {key: "0", "a": value, **zeros})
                parent.insert(list(parent).index(pieces[0]), start)


def road_between_junctions(root: ElementTree.Element) -> str:
    """Return a road in a junction that leads into another one, "" if there is none."""
    for road in root.iter("road"):
        for link in road.findall("link/*") if road.get("junction", "-1") != "-1" else ():
            if link.get("elementType") == "junction":
                place = f"road {road.get('id')} of junction {road.get('junction')}"
                return f"{place} leads into junction {link.get('elementId')}"
    return ""


def _write_arcs(road: ElementTree.Element) -> None:
    """Write an arc or a line for a spiral of one curvature, on which netconvert does not end.

    It does not end on a piece without a length, either.
    """
    for view in road.findall("planView"):
        view[:] = [one for one in view if float(one.get("length", 1.0)) != 0.0] or view[:1]
    for shape in road.findall("planView/geometry/*"):
        first, last = (float(shape.get(name, 0.0)) for name in ("curvStart", "curvEnd"))
        curvature = float(shape.get("curvature", first))
        if shape.tag == "spiral" and abs(last - first) < _SAME_CURVATURE or shape.tag == "arc":
            is_straight = abs(curvature) < _SAME_CURVATURE
            shape.tag = "line" if is_straight else "arc"
            shape.attrib = {} if is_straight else {"curvature": repr(curvature)}


def _write_access(lane: ElementTree.Element) -> None:
    """Write the restrictions of OpenDRIVE 1.8 as those before it."""
    for access in lane.findall("access"):
        for one in access.findall("restriction"):
            names = {**access.attrib, "restriction": one.get("type", "none")}
            ElementTree.SubElement(lane, "access", names)
        if "restriction" not in access.attrib:
            lane.remove(access)


def _write_widths(section: ElementTree.Element) -> None:
    """Write the widths of lanes whose outer border the file has instead."""
    for side in ("left", "right") if section.find(".//border") is not None else ():
        inner = np.zeros((1, 5))
        lanes = section.findall(side + "/lane")
        for lane in sorted(lanes, key=lambda lane: abs(int(lane.attrib["id"]))):
            widths = cubics(lane.findall("width"), "sOffset")
            borders = cubics(lane.findall("border"), "sOffset")
            if len(widths) or not len(borders):
                inner = _sum(inner, widths if len(widths) else np.zeros((1, 5)), 1.0)
                continue
            # On the right borders are negative in the standard, and positive in some files.
            if borders[:, 1].min() < 0.0:
                borders[:, 1:] *= -1.0
            for row in _sum(borders, inner, -1.0):
                names = dict(zip(("sOffset", *"abcd"), map(repr, row.tolist())))
                ElementTree.SubElement(lane, "width", names)
            inner = borders


def _sum(one: np.ndarray, other: np.ndarray, factor: float) -> np.ndarray:
    """Return the pieces (N, 5) of a piecewise cubic plus `factor` times another one."""
    starts = np.unique(np.append(one[:, 0], other[:, 0]))
    return np.array([[s, *(_cubic_at(one, s) + factor * _cubic_at(other, s))] for s in starts])


def _cubic_at(pieces: np.ndarray, s: float) -> np.ndarray:
    """Return the coefficients (4,) of a piecewise cubic whose parameter begins at s."""
    start, a, b, c, d = pieces[max(np.searchsorted(pieces[:, 0], s, side="right") - 1, 0)]
    t = s - start
    return np.array(
        [a + t * (b + t * (c + t * d)), b + t * (2.0 * c + 3.0 * t * d), c + 3.0 * t * d, d]
    )


def _write_limits(road: ElementTree.Element) -> None:
    """Write the speed limits of a road to its lanes, each on its part of a lane section.

    A section is also split where cars may cross a line between two lanes from there on, or may not.
    """
    of_road = [(float(one.get("s", 0.0)), _limit_mps(one)) for one in road.findall("type")]
    of_road.sort(key=lambda row: row[0])
    for section, start_m, end_m in sections(road):
        lanes = {lane.attrib["id"]: lane for lane in section.iter("lane")}
        if len(lanes) < len([*section.iter("lane")]):
            raise ValueError(f"two lanes of the section at {start_m:g} m have one id")
        lanes.pop("0", None)
        of_lanes = [
            [(start_m + s, _limit_mps(one)) for s, one in _along(lane, "speed")]
            for lane in lanes.values()
        ]
        of_lines = [
            [(start_m + s, _is_crossed(one)) for s, one in _along(lane, "roadMark")]
            for name, lane in lanes.items()
            if _is_beside_another(int(name), lanes)
        ]
        tables: list[list[tuple[float, Any]]] = [of_road, *of_lanes, *of_lines]
        places = {s for rows in tables for s, _ in rows}
        inside = (s for s in places if start_m + _SAME_PLACE_M < s < end_m - _SAME_PLACE_M)
        places_m = [start_m, *sorted(inside)]
        limits = [[_last(rows, s) or _last(of_road, s) for s in places_m] for rows in of_lanes]
        lines = [[_last(rows, s) for s in places_m] for rows in of_lines]
        changes = [
            number
            for number in range(len(places_m))
            if not number or any(row[number] != row[number - 1] for row in (*limits, *lines))
        ]
        for number, part in zip(changes, _split(road, section, [places_m[n] for n in changes])):
            for lane, row in zip(
                (one for one in part.iter("lane") if one.get("id") != "0"), limits
            ):
                for speed in lane.findall("speed"):
                    lane.remove(speed)
                if row[number] is not None:
                    limit = repr(row[number])
                    ElementTree.SubElement(lane, "speed", sOffset="0.0", max=limit, unit="m/s")


def _split(
    road: ElementTree.Element, section: ElementTree.Element, starts_m: list[float]
) -> list[ElementTree.Element]:
    """Replace a lane section by parts that begin at places along the road, and return them."""
    parts: list[ElementTree.Element] = []
    for first, last in zip(starts_m, [*starts_m[1:], math.inf]):
        part = copy.deepcopy(section)
        part.set("s", repr(first))
        for lane in part.iter("lane"):
            _cut(lane, first - starts_m[0], last - starts_m[0])
            link = lane.find("link")
            link = ElementTree.SubElement(lane, "link") if link is None else link
            for way, is_inside in (
                ("predecessor", bool(parts)),
                ("successor", last < math.inf),
            ):
                for old in link.findall(way) if is_inside else ():
                    link.remove(old)
                if is_inside:
                    ElementTree.SubElement(link, way, id=lane.attrib["id"])
        parts.append(part)
    (parent,) = road.findall("lanes")
    number = list(parent).index(section)
    parent[number : number + 1] = parts
    return parts


def _cut(lane: ElementTree.Element, first_m: float, last_m: float) -> None:
    """Leave of a lane what is between two places in its section [m]."""
    for kind in ("width", "roadMark"):
        found = _along(lane, kind)
        before = [one for s, one in found if s <= first_m][:-1]
        for s, element in found:
            if element in before or s >= last_m:
                lane.remove(element)
                continue
            if kind == "width":
                moved = _cubic_at(cubics([element], "sOffset"), max(first_m, s)).tolist()
                element.attrib.update(zip("abcd", map(repr, moved)))
            element.set("sOffset", repr(max(s - first_m, 0.0)))


def _along(lane: ElementTree.Element, kind: str) -> list[tuple[float, ElementTree.Element]]:
    """Return the elements of a kind of a lane, with their places in its section [m]."""
    return [(float(one.get("sOffset", 0.0)), one) for one in lane.findall(kind)]


def _is_crossed(mark: ElementTree.Element) -> bool:
    """Return whether cars may cross a line."""
    return mark.get("type", "none") == "none" or mark.attrib["type"].startswith("b")


def _is_beside_another(number: int, lanes: dict[str, ElementTree.Element]) -> bool:
    """Return whether cars drive on a lane and on the next one outside of it."""
    both = (lanes.get(str(one)) for one in (number, number + (1 if number > 0 else -1)))
    return all(lane is not None and lane.get("type") in _FOR_CARS for lane in both)


def _last(rows: list[tuple[float, Any]], s_m: float) -> Any:
    """Return what applies at a place along the road, None if nothing does."""
    return next((value for s, value in reversed(rows) if s <= s_m + _SAME_PLACE_M), None)


def _limit_mps(parent: ElementTree.Element) -> float | None:
    """Return the speed limit of a type of road or of a lane, None without one [m/s]."""
    speed = parent if parent.tag == "speed" else parent.find("speed")
    text = "" if speed is None else speed.get("max", "")
    if speed is None or text in ("", "undefined"):
        return _NO_LIMIT_MPS if parent.get("type") == "motorway" else None
    if text == "no limit":
        return _NO_LIMIT_MPS
    unit = speed.get("unit") or "m/s"
    if unit not in _UNITS_MPS:
        raise ValueError(f"unit {unit!r} of a speed limit is unknown; write km/h, mph or m/s")
    limit_mps = float(text) * _UNITS_MPS[unit]
    return limit_mps if 0.0 < limit_mps < math.inf else None
