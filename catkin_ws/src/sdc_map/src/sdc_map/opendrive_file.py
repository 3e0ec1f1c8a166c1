"""Read a file of OpenDRIVE, and write into it what netconvert would not read."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from typing import Iterable, Iterator

_UNITS_MPS = {"mph": 0.44704, "km/h": 1.0 / 3.6, "m/s": 1.0}
# Limit where the file has none [m/s]; it is that of netconvert for lanes of the type driving.
_DEFAULT_MPS = 13.89
# Limit where the file has "no limit" [m/s]: the recommended speed of German motorways, 130 km/h.
_NO_LIMIT_MPS = 130.0 / 3.6
# Limits and sections that begin so close to each other begin at one place.
_SAME_PLACE_M = 1.0


def read_opendrive(path: str) -> ElementTree.Element:
    """Return the tree of a file in the form that netconvert reads.

    Each lane has its speed limits, those of the road, too. The projection and the offset are left
    out: positions are those of the file, as CARLA uses them.

    Raises:
        ElementTree.ParseError, KeyError, ValueError: it is not valid OpenDRIVE
    """
    root = ElementTree.parse(path).getroot()
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    if root.tag != "OpenDRIVE":
        raise ValueError("it has no element OpenDRIVE")
    for header in root.findall("header"):
        for element in [*header.findall("geoReference"), *header.findall("offset")]:
            header.remove(element)
    for road in root.iter("road"):
        _write_limits(road)
    return root


def sections(road: ElementTree.Element) -> Iterator[tuple[ElementTree.Element, float, float]]:
    """Return the lane sections of a road with their start and end along it [m]."""
    found = road.findall("lanes/laneSection")
    ends = [*(float(section.attrib["s"]) for section in found), float(road.attrib["length"])]
    return zip(found, ends, ends[1:])


def _write_limits(road: ElementTree.Element) -> None:
    """Write the speed limits of a road to its lanes, each where it begins."""
    of_road = [(float(one.get("s", 0.0)), _limit_mps(road, one)) for one in road.findall("type")]
    for section, start_m, end_m in sections(road):
        lanes = [lane for lane in section.iter("lane") if lane.attrib["id"] != "0"]
        of_lanes = [
            [
                (start_m + float(speed.get("sOffset", 0.0)), _limit_mps(road, [speed]))
                for speed in lane.findall("speed")
            ]
            for lane in lanes
        ]
        places = {s for limits in (of_road, *of_lanes) for s, _ in limits}
        inside = (s for s in places if start_m + _SAME_PLACE_M < s < end_m - _SAME_PLACE_M)
        places_m = [start_m, *sorted(inside)]
        limits = [
            [_last(of_lane, s) or _last(of_road, s) for s in places_m] for of_lane in of_lanes
        ]
        # netconvert splits a road at each limit, also if it is that of the stretch before.
        changes = [
            number
            for number in range(len(places_m))
            if not number or any(row[number] != row[number - 1] for row in limits)
        ]
        for lane, row in zip(lanes, limits):
            for speed in lane.findall("speed"):
                lane.remove(speed)
            for number in changes if any(row) else ():
                offset, limit = places_m[number] - start_m, row[number] or _DEFAULT_MPS
                ElementTree.SubElement(
                    lane, "speed", sOffset=repr(offset), max=repr(limit), unit="m/s"
                )


def _last(limits: list[tuple[float, float | None]], s_m: float) -> float | None:
    """Return the limit at a place along the road, None without one [m/s]."""
    return next((limit for s, limit in reversed(limits) if s <= s_m + _SAME_PLACE_M), None)


def _limit_mps(road: ElementTree.Element, parent: Iterable[ElementTree.Element]) -> float | None:
    """Return the speed limit that an element contains, None without one [m/s]."""
    speed = next((child for child in parent if child.tag == "speed"), None)
    text = "undefined" if speed is None else speed.get("max", "undefined")
    if speed is None or text in ("undefined", "no limit"):
        return _NO_LIMIT_MPS if text == "no limit" else None
    unit = speed.get("unit", "m/s")
    if unit not in _UNITS_MPS:
        raise ValueError(f"road {road.get('id')}: unit {unit!r} of a speed limit is unknown")
    return float(text) * _UNITS_MPS[unit] or None
