"""OpenDRIVE description of the road along a route."""

from __future__ import annotations

import math

import numpy as np

from sdc_sim.physics.traffic_lights import LANE_WIDTH_M

_LANE = (
    '<lane id="{id}" type="driving" level="false">'
    '<width sOffset="0" a="{width}" b="0" c="0" d="0"/>'
    '<roadMark sOffset="0" type="solid" color="standard" width="0.15"/></lane>'
)
_CENTRE = (
    '<lane id="0" type="none" level="false">'
    '<roadMark sOffset="0" type="broken" color="standard" width="0.15"/></lane>'
)


def opendrive(name: str, route_m: np.ndarray) -> str:
    """Return a road of straight pieces between the points of a route, as OpenDRIVE 1.4.

    The route is the reference line and the middle of the right lane; the coordinates are those of
    the map frame.

    Args:
        name: name of the road
        route_m: (N, 2) points of the route
    """
    steps = np.diff(np.asarray(route_m, float), axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    starts = np.concatenate([[0.0], np.cumsum(lengths)])
    pieces = [
        f'<geometry s="{s:.4f}" x="{x:.4f}" y="{y:.4f}" hdg="{math.atan2(dy, dx):.8f}" '
        f'length="{length:.4f}"><line/></geometry>'
        for s, (x, y), (dx, dy), length in zip(starts, route_m, steps, lengths)
        if length > 0.0
    ]
    left, right = (_LANE.format(id=number, width=LANE_WIDTH_M) for number in (1, -1))
    escaped = name.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<OpenDRIVE><header revMajor="1" revMinor="4" name="{escaped}"/>'
        f'<road name="{escaped}" length="{starts[-1]:.4f}" id="0" junction="-1">'
        f"<planView>{''.join(pieces)}</planView><lanes>"
        f'<laneOffset s="0" a="{0.5 * LANE_WIDTH_M}" b="0" c="0" d="0"/>'
        f'<laneSection s="0"><left>{left}</left><center>{_CENTRE}</center>'
        f"<right>{right}</right></laneSection></lanes></road></OpenDRIVE>\n"
    )
