"""Direct junctions of OpenDRIVE 1.7, at which roads meet without connecting roads."""

from __future__ import annotations

import itertools
import math
import xml.etree.ElementTree as ElementTree
from typing import NamedTuple

import numpy as np

from sdc_map.findings import Findings
from sdc_map.opendrive_lanes import pieces, piecewise_cubic, point_at, reference_line, sections

# Length of a connecting road where two roads meet at one point [m].
_SHORTEST_M = 0.1
_ENDS = ["start", "end"]


class _End(NamedTuple):
    """The end of a lane where its road meets a junction."""

    road: str
    contact: str  # "start" or "end" of the road
    lane: str
    kind: str  # type of the lane
    width_m: float
    inner_m: complex  # the end of its inner edge, which is on its left in its direction of travel
    heading_rad: float  # its direction of travel
    z_m: float  # its height

    @property
    def leads_in(self) -> bool:
        """Whether traffic leaves the lane at this end."""
        return (self.contact == "end") == (int(self.lane) < 0)


def write_connecting_roads(root: ElementTree.Element, findings: Findings) -> None:
    """Write a short connecting road for each pair of lanes that meet in a direct junction."""
    roads = {road.attrib["id"]: road for road in root.iter("road")}
    for junction in root.iter("junction"):
        if junction.attrib.pop("type", "default") != "direct":
            continue
        name, numbers = junction.attrib["id"], itertools.count()
        for connection in junction.findall("connection"):
            junction.remove(connection)
            incoming = roads[connection.attrib["incomingRoad"]]
            linked = roads[connection.attrib["linkedRoad"]]
            given = connection.get("contactPoint")
            contacts = [given] if given else _ENDS
            # The other end of the incoming road may be linked to the same junction.
            nearer, contact = min(
                itertools.product(_ENDS, contacts),
                key=lambda ends: math.dist(_place(incoming, ends[0]), _place(linked, ends[1])),
            )
            for link in connection.findall("laneLink"):
                first = _end(incoming, nearer, link.attrib["from"])
                last = _end(linked, contact, link.attrib["to"])
                if not first or not last or first.leads_in == last.leads_in:
                    text = f"junction {name}, lane {link.get('from')} to {link.get('to')}"
                    what = "links of direct junctions between other lanes"
                    findings.add(what, text, _place(incoming, "start"))
                    continue
                if last.leads_in:
                    first, last = last, first
                number = f"{name}.direct.{next(numbers)}"
                root.append(_connecting_road(number, name, first, last))
                made = {"incomingRoad": first.road, "connectingRoad": number}
                row = ElementTree.SubElement(
                    junction, "connection", made, id=number, contactPoint="start"
                )
                ElementTree.SubElement(row, "laneLink", {"from": first.lane, "to": "-1"})


def _place(road: ElementTree.Element, contact: str) -> tuple[float, float]:
    """Return the start or the end of the reference line of a road [m]."""
    return point_at(road, 0.0 if contact == "start" else float(road.attrib["length"]))


def _end(road: ElementTree.Element, contact: str, name: str) -> _End | None:
    """Return the end of a lane, None if the road does not have the lane there."""
    row = 0 if contact == "start" else -1
    section, *ends_m = [*sections(road)][row]
    piece = dict(pieces(road, section, *ends_m)).get(name)
    if piece is None:
        return None
    (lane,) = (lane for lane in section.iter("lane") if lane.get("id") == name)
    s = np.array([ends_m[row]])
    width_m = float(piecewise_cubic(lane.findall("width"), "sOffset", s - ends_m[0])[0])
    heading_rad = float(reference_line(road, s)[1][0]) + (math.pi if int(name) > 0 else 0.0)
    x_m, y_m, z_m = piece.points_m[row].tolist()
    inner_m = complex(x_m, y_m) + 0.5j * width_m * np.exp(1j * heading_rad)
    place = width_m, inner_m, heading_rad, z_m
    return _End(road.attrib["id"], contact, name, lane.get("type", ""), *place)


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
        f'length="{length_m}"><line/></geometry></planView><elevationProfile>'
        f'<elevation s="0" a="{first.z_m}" b="{(last.z_m - first.z_m) / length_m}" c="0" d="0"/>'
        "</elevationProfile>"
        f'<lanes><laneSection s="0"><center>{center}</center><right>'
        f'<lane id="-1" type="{first.kind}">{link}{width}</lane>'
        "</right></laneSection></lanes></road>"
    )
