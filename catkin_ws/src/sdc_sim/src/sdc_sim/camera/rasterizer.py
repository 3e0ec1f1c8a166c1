"""Projection, clipping and filling of polygons and of bodies for one pose of the vehicle."""

from __future__ import annotations

from typing import NamedTuple, Sequence

import cv2
import numpy as np

from sdc_sim.camera.camera_model import CameraModel
from sdc_sim.camera.painting import FIXED_POINT_BITS

# Distance of the near plane along the view.
NEAR_M = 0.4
# The smooth edges of a polygon reach no farther beyond it.
_EDGE_PX = 2
# Polygons of up to this size are left out.
_TINY_PX = 1.25
# Window panes are smaller than a pixel beyond so many metres for each pixel of the focal length.
_PANES_RANGE_M_PER_PX = 0.266


class Face(NamedTuple):
    """A visible face of a body, or the window panes of one."""

    # An outline (n, 2) in the picture, or a list of those of all panes.
    outlines: np.ndarray | list[np.ndarray]
    colour: tuple[float, ...]  # BGRA


class Solid(NamedTuple):
    """The faces of a body in the map, in the order in which they are painted."""

    polygons: np.ndarray  # corners (P, n, 3), counter-clockwise seen from outside [m]
    normals: np.ndarray  # vectors out of the faces (P, 3)
    bgr: np.ndarray  # colours in the light of the sun (P, 3)
    is_pane: np.ndarray  # whether a polygon is a window pane in the face before it (P,)


class PolygonRasterizer:
    """Rasterizer of polygons of the map.

    Outlines are int32 pixels with FIXED_POINT_BITS fractional bits.
    """

    def __init__(self, camera: CameraModel, x_m: float, y_m: float, yaw_rad: float):
        self.eye = camera.position_in_map(x_m, y_m, yaw_rad)  # of the camera (3,) [m]
        self.rotation = camera.map_from_optical(yaw_rad)  # from the optical frame to the map
        self.focal_px = camera.focal_px
        self._focal = self.focal_px * (1 << FIXED_POINT_BITS)
        self._middle = np.array([camera.width / 2.0, camera.height / 2.0]) * (1 << FIXED_POINT_BITS)
        self._edge = _EDGE_PX << FIXED_POINT_BITS
        self._end = 2.0 * self._middle + self._edge

    def pixels(self, optical: np.ndarray) -> np.ndarray:
        """Return the outline (..., 2) of points (..., 3) of the optical frame [m]."""
        pixels = self._focal * optical[..., :2] / optical[..., 2:] + self._middle
        return np.rint(pixels).astype(np.int32)

    def outlines(self, polygons: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the outlines of polygons of the map (P, n, 3) [m].

        Returns:
            the outlines (P, n, 2), and whether all of a polygon is beyond the near plane (P,);
            only then its outline is valid
        """
        optical = ((polygons - self.eye).reshape(-1, 3) @ self.rotation).reshape(polygons.shape)
        beyond = optical[..., 2].min(axis=1) >= NEAR_M
        optical[~beyond] = [0.0, 0.0, 1.0]
        return self.pixels(optical), beyond

    def may_see(self, outlines: np.ndarray) -> np.ndarray:
        """Return whether outlines (P, n, 2) may touch the picture and are not tiny (P,)."""
        low, high = outlines.min(axis=1), outlines.max(axis=1)
        seen = ((high >= -self._edge) & (low <= self._end)).all(axis=1)
        return seen & ((high - low).max(axis=1) > _TINY_PX * (1 << FIXED_POINT_BITS))

    def outline(self, polygon: np.ndarray) -> np.ndarray | None:
        """Return the outline (n, 2) of the visible part of a polygon (m, 3) of the map.

        Returns:
            the outline, or None if the polygon is behind the near plane
        """
        optical = (polygon - self.eye) @ self.rotation
        if optical[:, 2].min() >= NEAR_M:
            return self.pixels(optical)
        clipped = clip_near(optical)
        return None if clipped is None else self.pixels(clipped)


def clip_near(optical: np.ndarray) -> np.ndarray | None:
    """Return the part of a polygon beyond the near plane.

    Args:
        optical: corners (n, 3) in the optical frame [m]

    Returns:
        corners (m, 3), or None if nothing is left

    Reference: Sutherland and Hodgman, "Reentrant Polygon Clipping", CACM 1974.
    """
    kept = []
    previous = optical[-1]
    for point in optical:
        if (point[2] >= NEAR_M) != (previous[2] >= NEAR_M):
            kept.append(
                previous + (NEAR_M - previous[2]) / (point[2] - previous[2]) * (point - previous)
            )
        if point[2] >= NEAR_M:
            kept.append(point)
        previous = point
    return np.array(kept) if len(kept) >= 3 else None


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


def fill(picture: np.ndarray, outline: np.ndarray, colour: Sequence[float]) -> None:
    """Fill a convex outline (n, 2), with smooth edges."""
    cv2.fillConvexPoly(picture, outline, colour, cv2.LINE_AA, FIXED_POINT_BITS)


def paint(picture: np.ndarray, faces: Sequence[Face]) -> None:
    """Paint the faces of a body."""
    for outlines, colour in faces:
        if isinstance(outlines, list):
            cv2.fillPoly(picture, outlines, colour, cv2.LINE_AA, FIXED_POINT_BITS)
        else:
            fill(picture, outlines, colour)
