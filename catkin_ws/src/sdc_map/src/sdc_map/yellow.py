"""How long the lights of a network are yellow."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

# A driver brakes after this time [s], with this deceleration [m/s^2].
_REACTS_S = 1.0
_BRAKES_MPS2 = 3.0


def lengthen_yellow(root: ElementTree.Element) -> None:
    """Let lights be yellow so long that a car at the speed limit can pass if it cannot stop.

    netconvert gives the lights of OpenDRIVE 3 s, which is enough up to 50 km/h.

    Args:
        root: the tree of SUMO's network

    Reference: D. Gazis, R. Herman and A. Maradudin, The Problem of the Amber Signal Light in
    Traffic Flow, Operations Research 8(1), 1960.
    """
    lanes = {lane.attrib["id"]: float(lane.attrib["speed"]) for lane in root.iter("lane")}
    limits_mps = {
        (way.attrib["tl"], int(way.attrib["linkIndex"])): lanes[
            f"{way.attrib['from']}_{way.attrib['fromLane']}"
        ]
        for way in root.iter("connection")
        if "tl" in way.attrib
    }
    for program in root.iter("tlLogic"):
        for phase in program.iter("phase"):
            letters = phase.attrib["state"].lower()
            yellow = [index for index, letter in enumerate(letters) if letter == "y"]
            limit_mps = max(
                (limits_mps.get((program.attrib["id"], n), 0.0) for n in yellow), default=0.0
            )
            least_s = round(_REACTS_S + limit_mps / (2.0 * _BRAKES_MPS2))
            if yellow and float(phase.attrib["duration"]) < least_s:
                phase.set("duration", str(least_s))
