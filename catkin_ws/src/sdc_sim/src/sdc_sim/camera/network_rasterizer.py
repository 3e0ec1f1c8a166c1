"""Rasterizer of a network of lanes for the tiles of the ground: the areas, lines and crossings."""

from __future__ import annotations

import cv2
import numpy as np

from sdc_common.geometry.road_line import arc_lengths
from sdc_common.geometry.route import interpolate
from sdc_map.network import BROKEN, DOUBLE, KERB, STOP, WALKING, Junction, Network, left_normals
from sdc_sim.camera.painting import FIXED_POINT_BITS, halve, touching
from sdc_sim.camera.road_rasterizer import ASPHALT, SIDE_PX, Canvas, fixed_point
from sdc_sim.road.road import DASH_LENGTH_M, DASH_PERIOD_M, MARGIN_M
from sdc_sim.yaml_document import packaged_config

# Layers from the lowest to the highest: brightness as a share of that of paint, and share of grass
# 0..255.
_LAYERS = ((0.22, 140), (0.5, 0), (0.66, 0), (ASPHALT, 0))
_VERGE = 0  # index of the strip of grass and dirt beside a road
_PAVEMENT = 1  # index of a pavement, a lane of its own
_KERB = 2  # index of the border of a road
_ROAD = 3  # index of the asphalt
# How far the layers of a road reach beyond its lanes [m].
_BEYOND_M = {_VERGE: MARGIN_M + 1.1, _KERB: MARGIN_M + 0.25, _ROAD: MARGIN_M}
_PAINT = len(_LAYERS)
# Strips are straight pieces, at most so long and so far beside the line.
_LONGEST_M = 20.0
_TOLERANCE_M = 0.004
_DASH_POINTS = 7  # of a dash, which may be in a bend; straight parts lose theirs in _add
_DOUBLE_M = 0.14  # from the middle of a double line to each of its lines
_STRIPE_M, _STRIPE_PERIOD_M = 0.5, 1.0
# Strips along x by SUMO's direction.
_ARROWS = dict(packaged_config("signs")["arrows"])
_ARROWS["r"] = [((a, -b), (c, -d), *rest) for (a, b), (c, d), *rest in _ARROWS["l"]]
_ARROW_END_M = 9.0
_ZIGZAG_M = 2.0
_STOP_LINE_M, _TOOTH_M, _TOOTH_PERIOD_M = 0.4, 0.5, 0.8


class NetworkRasterizer:
    """Rasterizer of a network, tile by tile; see RoadRasterizer."""

    def __init__(self, network: Network):
        self._rows: list[np.ndarray] = []
        for lane in network.driving:
            self._add_road(lane.thinned.points_m, 0.5 * lane.width_m)
        for lane in (lane for lane in network.lanes.values() if lane.kind == WALKING):
            self._add(lane.thinned.points_m, _PAVEMENT, 0.5 * lane.width_m)
        for line in network.lines():
            if line.kind != KERB:
                self._add_line(line.points_m, line.kind)
        for ends, kind in network.stop_lines:
            if kind == STOP:
                self._add(ends, _PAINT, 0.5 * _STOP_LINE_M)
            else:
                self._add_dashes(ends, _TOOTH_M, _TOOTH_PERIOD_M, 0.5 * _STOP_LINE_M)
        for polygon in network.crosswalks:
            self._add_stripes(polygon)
        self._add_places(network)
        for junction in network.junctions.values():
            if junction.kind != "right_before_left" and len(junction.connections) > 2:
                self._add_arrows(network, junction)
        rows = np.vstack(self._rows)
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        self._layer, self._half_m = rows[:, 0].astype(int), rows[:, 1]
        self._start, self._end, self._left, self._end_left = (
            rows[:, 2:].reshape(-1, 4, 2).swapaxes(0, 1)
        )
        reach_m = self._half_m[:, None] * 1.5 + 1.0
        self._low = np.minimum(self._start, self._end) - reach_m
        self._high = np.maximum(self._start, self._end) + reach_m
        polygons_m = (junction.polygon_m for junction in network.junctions.values())
        self._areas = [polygon_m for polygon_m in polygons_m if len(polygon_m) > 2]
        self._area_low = np.array([area.min(axis=0) for area in self._areas]).reshape(-1, 2) - 1.0
        self._area_high = np.array([area.max(axis=0) for area in self._areas]).reshape(-1, 2) + 1.0

    def _add_road(self, points: np.ndarray, half_m: float) -> None:
        """Add the layers of a road along a line."""
        for layer, beyond_m in _BEYOND_M.items():
            self._add(points, layer, half_m + beyond_m)

    def _add(self, points: np.ndarray, layer: int, half_m: float) -> None:
        """Add a strip along a line; 0 is the width of a painted line."""
        line = np.asarray(points, np.float32)[:, None]
        points = cv2.approxPolyDP(line, _TOLERANCE_M, False)[:, 0].astype(float)
        s = arc_lengths(points)
        places = np.unique(np.append(s, np.arange(0.0, s[-1], _LONGEST_M)))
        points = interpolate(places, s, points)
        left = left_normals(points)
        head = np.tile([float(layer), half_m], (len(points) - 1, 1))
        self._rows.append(np.hstack([head, points[:-1], points[1:], left[:-1], left[1:]]))

    def _add_dashes(
        self, points: np.ndarray, dash_m: float, period_m: float, half_m: float
    ) -> None:
        s = arc_lengths(points)
        for start in np.arange(0.0, s[-1] - dash_m, period_m):
            places = np.linspace(start, start + dash_m, _DASH_POINTS)
            self._add(interpolate(places, s, points), _PAINT, half_m)

    def _add_line(self, points: np.ndarray, kind: str) -> None:
        if kind == BROKEN:
            self._add_dashes(points, DASH_LENGTH_M, DASH_PERIOD_M, 0.0)
        elif kind == DOUBLE:
            for side in (-_DOUBLE_M, _DOUBLE_M):
                self._add(points + side * left_normals(points), _PAINT, 0.0)
        else:
            self._add(points, _PAINT, 0.0)

    def _add_stripes(self, polygon: np.ndarray) -> None:
        """Add the stripes of a crosswalk: they are parallel to its short sides."""
        along, across = polygon[1] - polygon[0], polygon[2] - polygon[1]
        corner = polygon[0]
        if np.hypot(*along) < np.hypot(*across):
            corner, along, across = polygon[1], across, -along
        length = float(np.hypot(*along))
        for along_m in np.arange(0.5 * _STRIPE_PERIOD_M, length, _STRIPE_PERIOD_M):
            start = corner + along * (along_m / length)
            self._add(np.array([start, start + across]), _PAINT, 0.5 * _STRIPE_M)

    def _add_places(self, network: Network) -> None:
        """Add parking bays, and the zigzag lines of bus stops."""
        for start, end, far, near in network.bays:
            middle = 0.5 * np.array([start + near, end + far])
            half_m = 0.5 * float(np.hypot(*(near - start)))
            self._add_road(middle, half_m)
            for line in ([start, near], [end, far], [near, far]):
                self._add(np.array(line), _PAINT, 0.0)
        for start, end, far, near in network.bus_stops:
            count = max(2, int(np.hypot(*(end - start)) / _ZIGZAG_M)) + 1
            share = np.linspace(0.0, 1.0, count)[:, None]
            inner, outer = start + share * (end - start), near + share * (far - near)
            side = (np.arange(count) % 2)[:, None]
            self._add(inner + (0.15 + 0.7 * side) * (outer - inner), _PAINT, 0.0)

    def _add_arrows(self, network: Network, junction: Junction) -> None:
        """Add the arrows of the ways from each lane before a junction."""
        ways: dict[str, set[str]] = {}
        for way in junction.connections:
            ways.setdefault(way.start, set()).add(way.direction.lower())
        for name, directions in ways.items():
            lane = network.lanes[name]
            begin_m = lane.length_m - _ARROW_END_M
            if begin_m < _ARROW_END_M:
                continue
            (x, y), heading = lane.at(np.array([begin_m]))[0], lane.heading_at(begin_m)
            c, s = np.cos(heading), np.sin(heading)
            turn = np.array([[c, s], [-s, c]])
            for direction in sorted(directions & _ARROWS.keys()):
                for first, last, half_m, is_head in _ARROWS[direction]:
                    self._add(np.array([first, last]) @ turn + (x, y), _PAINT, half_m)
                    if is_head:
                        self._rows[-1][:, -2:] = 0.0

    def weights(
        self, level: int, origin_m: np.ndarray, size_m: float
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """Return brightness of the paved part and share of grass; see RoadRasterizer.weights."""
        near = touching(self._low, self._high, origin_m, origin_m + size_m)
        areas = touching(self._area_low, self._area_high, origin_m, origin_m + size_m)
        if len(near) == 0 and len(areas) == 0:
            return None
        place = Canvas(origin_m, size_m / SIDE_PX, level)
        line_half_m, ink = place.painted_line()
        half_m, is_line = self._half_m[near], self._half_m[near] == 0.0
        half_m = np.where(is_line, line_half_m, half_m)[:, None]
        start, end = self._start[near], self._end[near]
        left, end_left = half_m * self._left[near], half_m * self._end_left[near]
        corners = np.stack([start - left, end - end_left, end + end_left, start + left], axis=1)
        quads = fixed_point(place.pixels(corners))
        # Brightness and share of grass are painted at once, in two of three channels.
        canvas = np.zeros((SIDE_PX, SIDE_PX, 3), np.uint8)
        canvas[..., 1] = 255
        layers, ends = self._layer[near], np.arange(_PAINT + 1)
        # The rows are in the order of the layers.
        bounds = [0, *np.searchsorted(layers, ends, side="right").tolist()]
        colours = [(int(255 * brightness), share, 0) for brightness, share in _LAYERS]
        paint = [(255, 0, 0), (int(255 * ink), 0, 0)]
        kinds = is_line.tolist()
        for layer in range(_PAINT + 1):
            for k in range(bounds[layer], bounds[layer + 1]):
                colour = paint[kinds[k]] if layer == _PAINT else colours[layer]
                cv2.fillConvexPoly(canvas, quads[k], colour, place.line_type, FIXED_POINT_BITS)
            for k in areas.tolist() if layer in _BEYOND_M else ():
                area = fixed_point(place.pixels(self._areas[k]))
                cv2.fillPoly(canvas, [area], colours[layer], place.line_type, FIXED_POINT_BITS)
        paved, green, _ = cv2.split(halve(canvas))
        return paved, green
