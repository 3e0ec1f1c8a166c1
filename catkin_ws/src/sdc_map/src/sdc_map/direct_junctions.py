"""Direct junctions of OpenDRIVE 1.7, at which roads meet without connecting roads."""

from __future__ import annotations

import itertools
import math
import xml.etree.ElementTree as ElementTree
from typing import NamedTuple

import numpy as np

from sdc_map.road_geometry import piecewise_cubic, reference_line

# Length of a connecting road where two roads meet at one point [m].
_SHORTEST_M = 0.1


class _End(NamedTuple):
    """The end of a lane where its road meets a junction."""

    road: str
    contact: str  # "start" or "end" of the road
    lane: str
    kind: str  # type of the lane
    width_m: float
    inner_m: complex  # the end of its inner edge, which is on its left in its direction of travel
    heading_rad: float  # its direction of travel

    @property
    def leads_in(self) -> bool:
        """Whether traffic leaves the lane at this end."""
        return (self.contact == "end") == (int(self.lane) < 0)


def write_connecting_roads(root: ElementTree.Element, left_out: dict[str, list[str]]) -> None:
    """Write a short connecting road for each pair of lanes that meet in a direct junction."""
    roads = {road.attrib["id"]: road for road in root.iter("road")}
    for junction in root.iter("junction"):
        if junction.attrib.pop("type", "default") != "direct":
            continue
        name, numbers = junction.attrib["id"], itertools.count()
        for connection in junction.findall("connection"):
            junction.remove(connection)
            names = connection.attrib["incomingRoad"], connection.attrib["linkedRoad"]
            linked = roads[names[1]]
            contact = connection.get("contactPoint") or _contact(linked, name, None)
            contacts = _contact(roads[names[0]], name, _place(linked, contact)), contact
            for link in connection.findall("laneLink"):
                lanes = link.attrib["from"], link.attrib["to"]
                ends = [_end(roads[road], *rest) for road, *rest in zip(names, contacts, lanes)]
                both = [end for end in ends if end is not None]
                both.sort(key=lambda end: not end.leads_in)
                if [end.leads_in for end in both] != [True, False]:
                    place = f"{names[0]} {lanes[0]} to {names[1]} {lanes[1]}"
                    what = "links of direct junctions between other lanes"
                    left_out.setdefault(what, []).append(place)
                    continue
                number = f"{name}.direct.{next(numbers)}"
                root.append(_connecting_road(number, name, *both))
                made = {"incomingRoad": both[0].road, "connectingRoad": number}
                row = ElementTree.SubElement(
                    junction, "connection", made, id=number, contactPoint="start"
                )
                ElementTree.SubElement(row, "laneLink", {"from": both[0].lane, "to": "-1"})


def _contact(road: ElementTree.Element, junction: str, place_m: complex | None) -> str:
    """Return the end of a road that is linked to a junction, of two the nearer one to a place."""
    found = [
        contact
        for way, contact in (("predecessor", "start"), ("successor", "end"))
        for link in road.findall("link/" + way)
        if (link.get("elementType"), link.get("elementId")) == ("junction", junction)
    ] or ["start", "end"]
    if place_m is None:
        return found[0]
    return min(found, key=lambda contact: abs(_place(road, contact) - place_m))


def _place(road: ElementTree.Element, contact: str) -> complex:
    """Return the start or the end of the reference line of a road, as a complex number [m]."""
    s = np.array([0.0 if contact == "start" else float(road.attrib["length"])])
    return complex(*reference_line(road, s)[0][0])


def _end(road: ElementTree.Element, contact: str, lane: str) -> _End | None:
    """Return the end of a lane, None if the road does not have the lane there."""
    length_m = float(road.attrib["length"])
    section = road.findall("lanes/laneSection")[0 if contact == "start" else -1]
    s_m = 0.0 if contact == "start" else length_m
    side = "right" if int(lane) < 0 else "left"
    sign = -1.0 if int(lane) < 0 else 1.0
    inner_m = float(piecewise_cubic(road.findall("lanes/laneOffset"), "s", np.array([s_m]))[0])
    found = section.findall(side + "/lane")
    for element in sorted(found, key=lambda one: abs(int(one.attrib["id"]))):
        at = np.array([s_m - float(section.attrib["s"])])
        width_m = float(piecewise_cubic(element.findall("width"), "sOffset", at)[0])
        if element.attrib["id"] == lane:
            _, (heading_rad,) = reference_line(road, np.array([s_m]))
            edge_m = _place(road, contact) + 1j * inner_m * np.exp(1j * heading_rad)
            direction_rad = heading_rad + (0.0 if sign < 0.0 else math.pi)
            kind = element.get("type", "")
            return _End(road.attrib["id"], contact, lane, kind, width_m, edge_m, direction_rad)
        inner_m += sign * width_m
    return None


def _connecting_road(name: str, junction: str, first: _End, last: _End) -> ElementTree.Element:
    """Return a road with one lane from the end of a lane to the start of another one."""
    gap_m = last.inner_m - first.inner_m
    heading_rad = float(np.angle(gap_m)) if abs(gap_m) > _SHORTEST_M else first.heading_rad
    length_m = max(abs(gap_m), _SHORTEST_M)
    links = "".join(
        f'<{way} elementType="road" elementId="{end.road}" contactPoint="{end.contact}"/>'
        for way, end in (("predecessor", first), ("successor", last))
    )
    place = first.inner_m
    center = '<lane id="0" type="none"/>'
    link = f'<link><predecessor id="{first.lane}"/><successor id="{last.lane}"/></link>'
    width = f'<width sOffset="0" a="{first.width_m}" b="0" c="0" d="0"/>'
    return ElementTree.fromstring(
        f'<road id="{name}" junction="{junction}" length="{length_m}"><link>{links}</link>'
        f'<planView><geometry s="0" x="{place.real}" y="{place.imag}" hdg="{heading_rad}" '
        f'length="{length_m}"><line/></geometry></planView>'
        f'<lanes><laneSection s="0"><center>{center}</center><right>'
        f'<lane id="-1" type="{first.kind}">{link}{width}</lane>'
        "</right></laneSection></lanes></road>"
    )
