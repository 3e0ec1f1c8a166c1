"""Report what a map contains, and what its file has otherwise; draw it."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from typing import Any, Iterable, Iterator

import numpy as np

from sdc_common.configuration import how_to_install
from sdc_map.findings import FilePlace
from sdc_map.network import DRIVING, WALKING, Junction, Network, edge_of
from sdc_map.network_file import MapError, load_network

# Most pixels of a picture along its longer side, and for a metre of the map.
_PIXELS = 5000
_PIXELS_PER_M = 6.0
# Length of that side, which decides about the size of letters.
_INCHES = 16.0
# What a picture shows around the lanes [m].
_MARGIN_M = 20.0


def _is_junction(junction: Junction) -> bool:
    """Return whether there is a choice of ways: at a place within a road, lanes begin or end."""
    ways = {(edge_of(way.start), edge_of(way.end)) for way in junction.connections}
    return any(len({way[end] for way in ways}) < len(ways) for end in (0, 1))


def report_lines(network: Network) -> Iterator[str]:
    """Yield what a map contains, and each kind of thing that its file has otherwise."""
    outside = [lane for lane in network.lanes.values() if not lane.junction]
    streets = [lane for lane in outside if lane.kind == DRIVING]
    sidewalks = sum(lane.kind == WALKING for lane in outside)
    length_km = sum(lane.length_m for lane in network.driving) / 1000.0
    yield (
        f"{network.name}: {len(network.driving)} lanes for cars, {length_km:.1f} km; "
        f"{sidewalks} sidewalks, {len(outside) - len(streets) - sidewalks} other lanes"
    )
    junctions = [junction for junction in network.junctions.values() if _is_junction(junction)]
    types = Counter(junction.kind for junction in junctions).most_common()
    names = ", ".join(f"{number} {kind}" for kind, number in types)
    yield f"junctions: {len(junctions)}" + (f" ({names})" if names else "")
    lights = [junction for junction in network.junctions.values() if junction.phases]
    lines = Counter(kind for _, kind in network.stop_lines)
    yield (
        f"junctions with lights: {len(lights)}; {lines['stop']} stop lines, {lines['yield']} give "
        f"way lines, {len(network.crosswalks)} crosswalks"
    )
    yield f"limits: {_range([3.6 * lane.speed_limit_mps for lane in streets])} km/h"
    reason = f" ({network.findings.side})" if network.findings.side else ""
    yield f"traffic: on the {'left' if network.y_sign < 0.0 else 'right'}{reason}"
    heights_m = [height_m for lane in network.driving for height_m in lane.z_m.tolist()]
    yield f"heights: {_range(heights_m, 1)} m"
    x, y, end_x, end_y = network.bounds_m
    yield f"size: x from {x:.0f} to {end_x:.0f} m, y from {y:.0f} to {end_y:.0f} m"
    yield from (f"other than in the file: {line}" for line in network.findings.lines())


def _range(values: Iterable[float], digits: int = 0) -> str:
    """Return the least and the greatest value as text."""
    # A zero is added to -0.0.
    ends = (round(choose(values), digits) + 0.0 for choose in (min, max))
    least, greatest = (f"{end:.{digits}f}" for end in ends)
    return least if least == greatest else f"{least} to {greatest}"


def draw(network: Network, path: str) -> None:
    """Draw a map into a PNG file.

    Lanes for cars have a colour by their limit; sidewalks and other lanes are grey.

    Raises:
        OSError: the file cannot be written
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # takes 0.5 s
        from matplotlib.collections import LineCollection, PolyCollection
        from matplotlib.figure import Figure
    except ImportError:
        raise MapError(f"picture: matplotlib is missing; {how_to_install('plots')}") from None

    x, y, end_x, end_y = network.bounds_m
    size_m = np.array([end_x - x, end_y - y]) + 2.0 * _MARGIN_M
    pixels = min(max(_PIXELS_PER_M * size_m.max(), 1000.0), _PIXELS)
    figure = Figure(size_m / size_m.max() * _INCHES + 2.0, pixels / _INCHES, layout="constrained")
    axes = figure.add_subplot(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    axes.set_xlim(x - _MARGIN_M, end_x + _MARGIN_M)
    axes.set_ylim(y - _MARGIN_M, end_y + _MARGIN_M)
    others = [lane for lane in network.lanes.values() if lane.kind != DRIVING]
    axes.add_collection(PolyCollection([lane.area_m for lane in others], color="#c8c8c8", zorder=1))
    limits = np.array([3.6 * lane.speed_limit_mps for lane in network.driving])
    lanes = PolyCollection(
        [lane.area_m for lane in network.driving], array=limits, cmap="viridis", zorder=2
    )
    figure.colorbar(axes.add_collection(lanes), label="limit [km/h]", shrink=0.5)
    axes.add_collection(PolyCollection(network.crosswalks, color="#e0a800", zorder=3))
    painted = [line.points_m for line in network.lines()]
    axes.add_collection(LineCollection(painted, color="white", linewidth=0.5, zorder=4))
    for kind, colour in (("stop", "#d1341f"), ("yield", "#ff8c00")):
        lines = [points for points, its_kind in network.stop_lines if its_kind == kind]
        axes.add_collection(LineCollection(lines, color=colour, linewidth=2, zorder=5))
    lights = [
        network.lanes[way.start].points_m[-1]
        for junction in network.junctions.values()
        for way in junction.connections
        if way.signal >= 0
    ]
    for points, marker, label in (
        (lights, "r.", "light"),
        *((_points(places), "x", kind) for kind, places in network.findings.places.items()),
    ):
        if len(points):
            axes.plot(*np.transpose(points), marker, zorder=6, label=f"{label} ({len(points)})")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", fontsize="small")
    FigureCanvasAgg(figure).print_png(path)


def _points(places: Iterable[FilePlace]) -> list[tuple[float, float]]:
    return [place.point_m for place in places if place.point_m is not None]


def main() -> int:
    """Run the command line, and return the exit status."""
    parser = argparse.ArgumentParser(prog="check.py", description=__doc__)
    parser.add_argument("map", help=".xodr, .osm or .net.xml, or the name of a packaged map")
    parser.add_argument("--picture", metavar="PNG", help="draw the map into this file")
    parser.add_argument("--lanes", action="store_true", help="also print the lanes for cars")
    return check(parser.parse_args())


def check(given: Any) -> int:
    """Check the map `given.map`, print its `given.lanes`, and draw its `given.picture`."""
    try:
        network = load_network(given.map)
        print(*report_lines(network), sep="\n")
        for lane in network.driving if given.lanes else ():
            if not lane.junction:
                (x, y), (end_x, end_y) = lane.points_m[[0, -1]]
                print(f"{lane.id}: ({x:.1f}, {y:.1f}) to ({end_x:.1f}, {end_y:.1f})")
        if given.picture:
            draw(network, given.picture)
    except (MapError, OSError) as error:
        print(f"check: {error}", file=sys.stderr)
        return 2
    return 0
