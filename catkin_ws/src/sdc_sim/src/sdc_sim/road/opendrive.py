"""OpenDRIVE description of the road along a route."""

from __future__ import annotations

import codecs
import gzip
import math
import os
import xml.etree.ElementTree as ElementTree
from xml.sax.saxutils import escape

import numpy as np

from sdc_sim.physics.traffic_lights import LANE_WIDTH_M
from sdc_sim.yaml_document import packaged_config


def opendrive(name: str, route_m: np.ndarray) -> str:
    """Return a road of straight pieces between the points of a route, as OpenDRIVE 1.4.

    The route is the reference line and the middle of the right lane; the coordinates are those of
    the map frame.
    """
    steps = np.diff(np.asarray(route_m, float), axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    starts = np.concatenate([[0.0], np.cumsum(lengths)])
    part = packaged_config("opendrive")
    pieces = [
        part["piece"].format(s=s, x=x, y=y, heading=math.atan2(dy, dx), length=length)
        for s, (x, y), (dx, dy), length in zip(starts, route_m, steps, lengths)
        if length > 0.0
    ]
    left, right = (part["lane"].format(id=number, width=LANE_WIDTH_M) for number in (1, -1))
    road = part["road"].format(
        name=escape(name, {'"': "&quot;"}),
        length=starts[-1],
        pieces="".join(pieces),
        half_width=0.5 * LANE_WIDTH_M,
        left=left,
        right=right,
    )
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{road}\n'


def opendrive_file(path: str) -> str:
    """Return the content of an OpenDRIVE file, or of that beside SUMO's network; "" if none."""
    path = path.replace(".net.xml", ".xodr")
    if not path.lower().endswith((".xodr", ".xodr.gz")) or not os.path.exists(path):
        return ""
    with open(path, "rb") as file:
        content = file.read()
    if content.startswith(b"\x1f\x8b"):
        content = gzip.decompress(content)
    try:
        return content.decode()
    except UnicodeDecodeError:  # Its first line names its encoding; UTF-16 has a mark, too.
        has_mark = content[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
        root = ElementTree.fromstring(content.decode("utf-16") if has_mark else content)
        return ElementTree.tostring(root, "unicode")
