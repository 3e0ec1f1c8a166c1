"""Left-hand traffic, in a mirror: the rules of the road are written for traffic on the right.

A map with traffic on the left is mirrored at the x axis, read and driven by SUMO as one with
traffic on the right, and its network is mirrored back.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from typing import Any, Sequence

import numpy as np

from sdc_map.network import Network

# Numbers of OpenDRIVE that have the other sign in a mirror, by element, of those that are read.
_NEGATED = {
    "geometry": ("y", "hdg"),
    "arc": ("curvature",),
    "spiral": ("curvStart", "curvEnd"),
    "poly3": (*"abcd",),
    "paramPoly3": ("aV", "bV", "cV", "dV"),
    "laneOffset": (*"abcd",),
    "border": (*"abcd",),
    "lane": ("id",),
    "predecessor": ("id",),
    "successor": ("id",),
    "laneLink": ("from", "to"),
    "validity": ("fromLane", "toLane"),
    "signal": ("t", "hOffset"),
    "signalReference": ("t",),
    "object": ("t", "hdg", "roll"),
    "repeat": ("tStart", "tEnd"),
    "cornerLocal": ("v",),
}
_SIDES = {"left": "right", "right": "left", "increase": "decrease", "decrease": "increase"}
_SIDE = re.compile("left|right")
# Where the line of a way is beside a lane of OpenStreetMap.
_PLACEMENT = re.compile(r"(\w+_of:)(\d+)")
# SUMO's directions of the ways through a junction; upper case: partly to this side.
_TURNS = str.maketrans("lrLR", "rlRL")
# A place (x, y) in the text of a finding.
_PLACE = re.compile(r"\((-?\d+), (-?\d+)\)")
_FLIP = np.array([1.0, -1.0])


def mirror_opendrive(root: ElementTree.Element) -> None:
    """Mirror the tree of an OpenDRIVE file, and change the side of its traffic."""
    for element in list(root.iter()):
        for name in _NEGATED.get(element.tag, ()):
            if name in element.attrib:
                element.set(name, _negated(element.attrib[name]))
        for name in ("side", "laneChange"):
            if name in element.attrib:
                element.set(name, _SIDES.get(element.attrib[name], element.attrib[name]))
        if element.tag == "validity":  # from the least number to the greatest
            ends = (element.get("toLane", ""), element.get("fromLane", ""))
            element.attrib.update(zip(("fromLane", "toLane"), ends))
        elif element.tag == "laneSection":
            for part in element:
                part.tag = _SIDES.get(part.tag, part.tag)
                part[:] = reversed(part)
            element[:] = reversed(element)
        elif element.tag == "road":
            element.set("rule", "RHT" if element.get("rule") == "LHT" else "LHT")


def mirror_left_hand(root: ElementTree.Element) -> bool:
    """Mirror the tree of an OpenDRIVE file with traffic on the left; return whether it is one.

    Raises:
        ValueError: it has roads of both rules
    """
    roads: dict[bool, str | None] = {}
    for road in root.iter("road"):
        roads.setdefault(road.get("rule", "").upper() == "LHT", road.get("id"))
    if len(roads) > 1:
        text = f'road {roads[True]} has left-hand traffic (rule="LHT"), and road {roads[False]} not'
        raise ValueError(f"{text}; give all roads one rule")
    if True in roads:
        mirror_opendrive(root)
    return True in roads


def mirrored_tags(tags: dict[str, str]) -> dict[str, str]:
    """Return the tags of a way of OpenStreetMap, whose lanes count from the left, in a mirror."""
    placement = _PLACEMENT.fullmatch(tags.get("placement", ""))
    if placement and tags.get("lanes", "").isdigit():
        lane = int(tags["lanes"]) + 1 - int(placement[2])
        tags = {**tags, "placement": f"{placement[1]}{lane}"}
    return {
        _SIDE.sub(_other_side, key): _SIDE.sub(_other_side, "|".join(value.split("|")[::-1]))
        for key, value in tags.items()
    }


def _other_side(side: re.Match[str]) -> str:
    return _SIDES[side[0]]


def move_net(root: ElementTree.Element, shift_m: Sequence[float]) -> bool:
    """Move the tree of a network of SUMO; mirror it first if traffic is on the left there.

    Returns:
        whether it is mirrored
    """
    is_left = root.attrib.pop("lefthand", "false") in ("true", "1")
    if not (is_left or any(shift_m)):
        return False
    sign = -1.0 if is_left else 1.0

    def moved(x: str, y: str) -> tuple[str, str]:
        return f"{float(x) - shift_m[0]:.4f}", f"{sign * (float(y) - shift_m[1]):.4f}"

    for element in root.iter():
        for name in [name for name in element.attrib if name.lower().endswith("shape")]:
            points = (point.split(",") for point in element.attrib[name].split())
            element.set(name, " ".join(",".join([*moved(x, y), *z]) for x, y, *z in points))
        if {"x", "y"} <= {*element.attrib}:
            element.attrib.update(zip("xy", moved(element.attrib["x"], element.attrib["y"])))
        if is_left and "dir" in element.attrib:
            element.set("dir", element.attrib["dir"].translate(_TURNS))
    return is_left


def _negated(number: str) -> str:
    """Return the text of a number with the other sign; that of lane 0 stays."""
    number = number.strip()
    if not re.search("[1-9]", number):
        return number
    return number[1:] if number[0] == "-" else "-" + number.lstrip("+")


def negated(row: Any, *names: str) -> Any:
    """Return a dataclass or a named tuple in which these numbers have the other sign."""
    changes = {name: -getattr(row, name) for name in names}
    return row._replace(**changes) if hasattr(row, "_replace") else replace(row, **changes)


def mirrored(network: Network) -> Network:
    """Return the mirror image of a network with traffic on the right: it is on the left there."""
    lanes = [
        replace(
            lane,
            points_m=lane.points_m * _FLIP,
            left_marking=lane.right_marking,
            right_marking=lane.left_marking,
            left=lane.right,
            right=lane.left,
        )
        for lane in network.lanes.values()
    ]
    junctions = [
        replace(
            junction,
            polygon_m=junction.polygon_m * _FLIP,
            connections=tuple(
                way._replace(direction=way.direction.translate(_TURNS))
                for way in junction.connections
            ),
        )
        for junction in network.junctions.values()
    ]
    areas = network.crosswalks, network.bays, network.bus_stops
    crosswalks, bays, stops = ([area_m * _FLIP for area_m in kind] for kind in areas)
    left = Network(network.name, lanes, junctions, crosswalks, bays, stops, network)
    left.net_path, left.findings.side = network.net_path, network.findings.side
    for kind, places in network.findings.places.items():
        for place in places:
            text = _PLACE.sub(lambda at: f"({at[1]}, {_negated(at[2])})", place.text)
            point_m = place.point_m and (place.point_m[0], -place.point_m[1])
            left.findings.add(kind, text, point_m)
    return left
