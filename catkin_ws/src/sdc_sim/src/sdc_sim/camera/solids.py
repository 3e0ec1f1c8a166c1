"""Bodies of flat faces in the camera picture: which faces are visible, and where."""

from __future__ import annotations

from typing import NamedTuple, Sequence

import numpy as np

from sdc_sim.camera.rasterizer import Face, PolygonRasterizer

# Window panes are smaller than a pixel beyond so many metres for each pixel of the focal length.
_PANES_RANGE_M_PER_PX = 0.266


class Solid(NamedTuple):
    """The faces of a body in the map, in the order in which they are painted."""

    polygons: np.ndarray  # corners (P, n, 3), counter-clockwise seen from outside [m]
    normals: np.ndarray  # vectors out of the faces (P, 3)
    bgr: np.ndarray  # colours in the light of the sun (P, 3)
    is_pane: np.ndarray  # whether a polygon is a window pane in the face before it (P,)


def project(
    rasterizer: PolygonRasterizer,
    solids: Sequence[Solid],
    ahead_m: np.ndarray,
    haze: np.ndarray,
    haze_bgr: np.ndarray,
) -> list[list[Face]]:
    """Project all bodies of a picture together, which is faster than one by one.

    Args:
        rasterizer: projection for the pose
        solids: the bodies
        ahead_m: their distances along the vehicle's heading (len(solids),) [m]
        haze: share of the haze's colour in that of each body (len(solids),)
        haze_bgr: the haze's colour (3,)

    Returns:
        the visible faces of each body, in the order in which they are painted
    """
    drawn: list[list[Face]] = [[] for _ in solids]
    if not solids:
        return drawn
    every = Solid(*map(np.concatenate, zip(*solids)))
    owners = np.repeat(np.arange(len(solids)), [len(solid.bgr) for solid in solids])
    shown = ((rasterizer.eye - every.polygons[:, 0]) * every.normals).sum(axis=1) > 0.0
    shown &= ~every.is_pane | (ahead_m[owners] < _PANES_RANGE_M_PER_PX * rasterizer.focal_px)
    rows = np.flatnonzero(shown)
    outlines, beyond = rasterizer.outlines(every.polygons[rows])
    # The near plane does not cut panes: those that it touches are left out.
    seen = np.where(beyond, rasterizer.may_see(outlines), ~every.is_pane[rows])
    rows, outlines, beyond = rows[seen], outlines[seen], beyond[seen]
    owner, is_pane, bgr = owners[rows], every.is_pane[rows], every.bgr[rows]
    bgr += haze[owner, None] * (haze_bgr - bgr)
    # The panes of a face are painted at once.
    continues = is_pane[1:] & is_pane[:-1] & (owner[1:] == owner[:-1])
    starts = np.flatnonzero(np.append(True, ~continues)[: len(rows)]).tolist()
    polygons = list(outlines)
    for start, end in zip(starts, [*starts[1:], len(rows)]):
        outline: np.ndarray | list[np.ndarray] | None = polygons[start]
        if is_pane[start]:
            outline = polygons[start:end]
        elif not beyond[start]:
            outline = rasterizer.outline(every.polygons[rows[start]])
        if outline is not None:
            drawn[owner[start]].append(Face(outline, (*bgr[start].tolist(), 255.0)))
    return drawn
