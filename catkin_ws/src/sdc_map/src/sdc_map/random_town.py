"""Draw a town that is new to every driver from a seed.

SUMO's netgenerate draws where streets run: a grid, a spider's web or a random net. Here the net
becomes a town: some streets are removed, the whole plan bends, streets get a kind (lanes and limit)
along their whole length, and junctions get lights, signs, right before left or a roundabout.
netconvert makes the network of it, with the options of the packaged town.

Points of the plan are complex numbers x + yi [m], so that a turn is a product.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import xml.etree.ElementTree as ElementTree
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, Sequence

import numpy as np
from numpy.polynomial import Polynomial
from scipy.interpolate import BSpline
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from sdc_map.sumo_programs import MapError, cached, lengthen_yellow, run

_LEFT_HAND_SHARE = 0.25  # of the towns
_LARGEST_SEED = 4294967295
# A change of the drawing is another version of each town.
_VERSION = Path(__file__).read_bytes()
_FIX = "report the seed, and take another one"
# Points along a street are so far apart [m].
_STEP_M = 2.0
# The plan is bent by a polynomial of this degree, and grows or shrinks by at most this share.
_DEGREE = 5
_BENT_SHARE = 0.7
# Least angle between two streets at a roundabout [rad].
_ROUNDABOUT_RAD = np.radians(65.0)
# Greatest angle between two of four streets that are opposite of each other by pairs [rad].
_OPPOSITE_RAD = np.radians(125.0)
# A street continues at a junction if it turns by less than this [rad], over about this distance.
_ON_RAD = np.radians(62.0)
_ON_M = 25.0
_RING_M = 24.0  # radius of a roundabout
_RING_POINTS = 24
# Radius of the corners of a junction, and of those of a roundabout [m].
_CORNER_M = 8.0
_ENTRY_M = 6.0
_CROSSED_SHARE = 0.35  # of the slow streets at a junction without lights
_LEAST_JUNCTIONS = 8  # of a town
_LEAST_RADIUS_M = 20.0  # of a bend


class StreetKind(NamedTuple):
    """A kind of street, a type of SUMO's plain XML."""

    name: str
    lanes: int  # in each direction
    limit_kmh: int
    sidewalk: bool
    block_m: float  # least distance between two junctions
    radius_m: float  # least radius of a bend


# In the order of right of way.
KINDS = (
    StreetKind("lane", 1, 30, True, 0.0, 0.0),
    StreetKind("street", 1, 50, True, 0.0, 20.0),
    StreetKind("avenue", 2, 50, True, 80.0, 40.0),
    StreetKind("boulevard", 3, 60, True, 100.0, 60.0),
    StreetKind("parkway", 2, 70, True, 140.0, 90.0),
    StreetKind("road", 1, 80, False, 180.0, 100.0),
    StreetKind("highway", 2, 100, False, 250.0, 180.0),
    StreetKind("motorway", 3, 120, False, 300.0, 280.0),
)
# A street is of one of so many kinds, the fastest for which it is long and straight enough.
_CHOICES = 5
_STREET = KINDS[1]


@dataclass(eq=False)
class _Street:
    """A street between two junctions."""

    name: str  # of SUMO's edge from the first to the second one
    ends: list[str]
    points: np.ndarray = field(repr=False)  # (N,) in this direction [m]
    kind: StreetKind = _STREET


class _Arm(NamedTuple):
    """A street as it leaves a junction."""

    street: _Street
    end: int  # of the street, 0 or 1

    @property
    def points(self) -> np.ndarray:
        """Points (N,) from the junction on [m]."""
        return self.street.points[:: -1 if self.end else 1]

    @property
    def direction(self) -> complex:
        """Step from the junction to the next point [m]."""
        return complex(self.points[1] - self.points[0])


def random_town(seed: int, options: str) -> str:
    """Return the path of the network of a town; draw it if it is not in the cache.

    Args:
        seed: seed of its random numbers
        options: file with the options of netconvert

    Raises:
        MapError: SUMO's programs are not installed, or the seed is too large
    """
    if seed > _LARGEST_SEED:
        raise MapError(f"random:{seed}: the seed must be at most {_LARGEST_SEED}")
    name = f"random_{seed}"
    folder = cached(f"{name}\n".encode() + _VERSION, lambda made: _draw(seed, options, made, name))
    return os.path.join(folder, f"{name}.net.xml")


def _draw(seed: int, options: str, made: str, name: str) -> None:
    """Draw a town, and write its network into a folder."""
    random = np.random.default_rng(seed)
    out = os.path.join(made, f"{name}.net.xml")
    with tempfile.TemporaryDirectory() as folder:
        arguments = ["-X", "never", "-c", shutil.copy(options, folder), "-o", out]
        is_left = random.random() < _LEFT_HAND_SHARE
        streets: list[_Street] = []
        while len(_arms(streets)) < _LEAST_JUNCTIONS:
            streets = _streets(random, *_net(random, name, folder))
        _choose_kinds(random, streets)
        for root, lines in _plain_xml(random, streets).items():
            ending = {"edges": "edg"}.get(root, root[:3])
            text = "\n".join([f"<{root}>", *lines, f"</{root}>", ""])
            Path(folder, f"town.{ending}.xml").write_text(text, encoding="utf-8")
        run("netconvert", arguments, out, name, _FIX)
    tree = ElementTree.parse(out)  # It leaves out the comment with the time of day.
    lengthen_yellow(tree.getroot())
    tree.write(out)
    if is_left:
        right = f"{name}_right.net.xml"
        os.rename(out, os.path.join(made, right))
        Path(out).write_text(f'<net lefthand="true" mirrorOf="{right}"/>\n', encoding="utf-8")


def _net(
    random: np.random.Generator, name: str, folder: str
) -> tuple[dict[str, complex], list[list[str]]]:
    """Return the places of a net of netgenerate, and the pairs of them that a street joins."""
    size = [str(number) for number in random.integers(4, 7, 2)]
    block_m = 160.0 * 2.0 ** random.random()
    kinds = (
        ("--grid", "--grid.x-number", size[0], "--grid.y-number", size[1], "--grid.length"),
        ("--spider", "--spider.arm-number", str(random.integers(5, 8)), "--spider.circle-number")
        + (str(random.integers(3, 5)), "--spider.omit-center", "--spider.space-radius"),
        ("--rand", "--rand.iterations", str(random.integers(50, 100)), "--rand.max-distance")
        + (f"{2.0 * block_m:.2f}", "--rand.min-angle", "55", "--rand.min-distance"),
    )
    kind = kinds[random.integers(len(kinds))]
    prefix = os.path.join(folder, "net")
    more = (f"{block_m:.2f}", "--seed", str(random.integers(2**31)), "-p", prefix)
    run("netgenerate", kind + more, prefix + ".nod.xml", name, _FIX)
    nodes = ElementTree.parse(prefix + ".nod.xml").iter("node")
    plan = {
        node.attrib["id"]: complex(*(float(node.attrib[axis]) for axis in "xy")) for node in nodes
    }
    edges = ElementTree.parse(prefix + ".edg.xml").iter("edge")
    pairs = {tuple(sorted((edge.attrib["from"], edge.attrib["to"]))) for edge in edges}
    return plan, [list(pair) for pair in sorted(pairs)]


def _streets(
    random: np.random.Generator, plan: dict[str, complex], pairs: list[list[str]]
) -> list[_Street]:
    """Return streets over a plan, some of which is removed, and which is bent."""
    ways = list(pairs)
    for number in random.permutation(len(pairs))[: int(random.uniform(0.0, 0.3) * len(pairs))]:
        ends = Counter(place for way in ways for place in way)
        if min(ends[place] for place in pairs[number]) > 3:
            ways.remove(pairs[number])
    places = np.array([*plan.values()])
    middle = 0.5 * (places.real.max() + places.real.min())
    middle = middle + 0.5j * (places.imag.max() + places.imag.min())
    size_m = np.abs(places - middle).max()
    # An analytic function keeps the angles at junctions. No two places become one, because the real
    # part of its derivative is positive: 1 plus terms of at most _BENT_SHARE in all.
    terms = random.uniform(0.0, 1.0, _DEGREE)
    terms = terms / terms.sum() * np.exp(2j * np.pi * random.random(_DEGREE))
    share, turn = random.uniform(0.5, 1.0) * _BENT_SHARE, np.exp(2j * np.pi * random.random())
    bent = size_m * turn * Polynomial([1.0, *(share * terms)]).integ()
    return [
        _Street(f"s{number}", [way[0], way[-1]], bent((_line(plan, way) - middle) / size_m))
        for number, way in enumerate(_joined(plan, ways))
    ]


def _joined(plan: dict[str, complex], ways: list[list[str]]) -> list[list[str]]:
    """Return ways over places without dead ends and loops; two that only meet become one.

    If that one would bend too sharply, both are removed.
    """
    while True:
        ends = Counter(place for way in ways for place in (way[0], way[-1]))
        place = next((place for place, count in ends.items() if count < 3), None)
        if place is None:
            return ways
        met = [way for way in ways if place in (way[0], way[-1])]
        ways = [way for way in ways if way not in met]
        if len(met) == 2:
            before, after = (way if way[-1] == place else way[::-1] for way in met)
            joined = before + after[-2::-1]
            if joined[0] != joined[-1] and _radius_m(_line(plan, joined)) > _LEAST_RADIUS_M:
                ways.append(joined)


def _line(plan: dict[str, complex], way: list[str]) -> np.ndarray:
    """Return the points (N,) of a way, whose corners are rounded [m]."""
    places = np.array([plan[place] for place in way])
    degree = min(len(way) - 1, 2)
    inner = np.linspace(0.0, 1.0, len(way) - degree + 1)
    knots = np.concatenate([np.zeros(degree), inner, np.ones(degree)])
    count = int(np.abs(np.diff(places)).sum() / _STEP_M) + 2
    return BSpline(knots, places, degree)(np.linspace(0.0, 1.0, count))


def _radius_m(points: np.ndarray) -> float:
    """Return the least radius of a line."""
    steps = np.diff(points)
    turns = np.abs(np.angle(steps[1:] / steps[:-1]))
    return float((np.abs(steps[1:]) / np.maximum(turns, 1e-6)).min())


def _arms(streets: Sequence[_Street]) -> dict[str, list[_Arm]]:
    """Return the streets at each junction, by direction."""
    arms: dict[str, list[_Arm]] = {}
    for street in streets:
        for end, place in enumerate(street.ends):
            arms.setdefault(place, []).append(_Arm(street, end))
    for around in arms.values():
        around.sort(key=lambda arm: float(np.angle(arm.direction)))
    return arms


def _choose_kinds(random: np.random.Generator, streets: Sequence[_Street]) -> None:
    """Give each street a kind, which is the same where it goes on at junctions."""
    numbers = {street: number for number, street in enumerate(streets)}
    turns_rad = np.zeros(len(streets))  # the greatest turn of each at its ends
    pairs = []
    for around in _arms(streets).values():
        turns = [
            (abs(float(np.angle(-arm.direction / other.direction))), i, j)
            for i, arm in enumerate(around)
            for j, other in enumerate(around[:i])
        ]
        free = {*range(len(around))}
        for turn_rad, i, j in sorted(turns):
            if turn_rad < _ON_RAD and {i, j} <= free:
                free -= {i, j}
                pairs.append([numbers[around[i].street], numbers[around[j].street]])
                turns_rad[pairs[-1]] = np.maximum(turns_rad[pairs[-1]], turn_rad)
    graph = coo_matrix((np.ones(len(pairs)), np.array(pairs).T), (len(streets), len(streets)))
    count, whole = connected_components(graph)
    for number in range(count):
        rows = np.flatnonzero(whole == number)
        lines = [streets[row].points for row in rows]
        block_m = min(np.abs(np.diff(line)).sum() for line in lines)
        radius_m = min(*map(_radius_m, lines), _ON_M / max(turns_rad[rows].max(), 1e-9))
        fits = [kind for kind in KINDS if block_m >= kind.block_m and radius_m >= kind.radius_m][
            -_CHOICES:
        ]
        kind = fits[random.integers(len(fits))]
        for row in rows:
            streets[row].kind = kind


def _junction(random: np.random.Generator, around: Sequence[_Arm]) -> str:
    """Return the kind of a junction: a type of SUMO, or "roundabout"."""
    kinds = [arm.street.kind for arm in around]
    ranks = sorted(map(KINDS.index, kinds))
    fastest_kmh = max(kind.limit_kmh for kind in kinds)
    most_lanes = max(kind.lanes for kind in kinds)
    draw, other = random.random(2)
    directions = np.array([arm.direction for arm in around])
    gaps_rad = np.angle(np.roll(directions, -1) / directions) % (2.0 * np.pi)
    has_room = gaps_rad.min() > _ROUNDABOUT_RAD
    if has_room and most_lanes == 1 and fastest_kmh <= _STREET.limit_kmh and draw < 0.35:
        return "roundabout"
    if ranks[-1] == 0:
        return "right_before_left" if other < 0.75 else "allway_stop"
    # A light with many phases, as of streets that do not continue, is red for too long.
    has_few_phases = len(around) < 4 or len(around) == 4 and gaps_rad.max() < _OPPOSITE_RAD
    can_have_lights = fastest_kmh <= 70 and ranks[-2] >= 1 and has_few_phases
    if can_have_lights and draw < (0.85 if most_lanes > 1 else 0.3):
        return "traffic_light"
    return "priority" if other < 0.7 else "priority_stop"


def _plain_xml(random: np.random.Generator, streets: Sequence[_Street]) -> dict[str, list[str]]:
    """Return the elements of SUMO's plain XML, by the first element of their file."""
    plain: dict[str, list[str]] = {"nodes": [], "edges": [], "connections": []}
    rings = []
    for place, around in sorted(_arms(streets).items()):
        kind = _junction(random, around)
        if kind == "roundabout":
            rings.append(_add_ring(plain, place, around))
            continue
        plain["nodes"].append(_node(place, around[0].points[0], kind, _CORNER_M))
        has_lights = kind == "traffic_light"
        more = "" if has_lights else ' priority="true"'
        for arm in around:
            is_slow = arm.street.kind.limit_kmh <= _STREET.limit_kmh
            is_drawn = random.random() < _CROSSED_SHARE
            if arm.street.kind.sidewalk and (has_lights or is_slow and is_drawn):
                edges = f"{arm.street.name} -{arm.street.name}"
                plain["connections"].append(f'<crossing node="n{place}" edges="{edges}"{more}/>')
    for street in streets:
        kind = street.kind.name
        plain["edges"] += [
            _edge(street.name, street.ends, street.points, kind),
            _edge(f"-{street.name}", street.ends[::-1], street.points[::-1], kind),
        ]
    plain["edges"] += rings
    plain["types"] = [
        f'<type id="{kind.name}" priority="{rank}" numLanes="{kind.lanes}" width="3.5" '
        f'speed="{kind.limit_kmh / 3.6:.2f}" '
        + ('sidewalkWidth="2.0"/>' if kind.sidewalk else 'disallow="pedestrian"/>')
        for rank, kind in enumerate(KINDS, 1)
    ] + ['<type id="ring" priority="9" speed="8.33" width="4" disallow="pedestrian"/>']
    return plain


def _node(name: str, place: complex, kind: str, radius_m: float) -> str:
    at = f'x="{place.real:.3f}" y="{place.imag:.3f}" type="{kind}" radius="{radius_m:g}"'
    return f'<node id="n{name}" {at}/>'


def _edge(
    name: str, ends: Sequence[str], points: np.ndarray, kind: str, spread: str = "right"
) -> str:
    shape = " ".join(f"{point.real:.3f},{point.imag:.3f}" for point in points)
    between = f'from="n{ends[0]}" to="n{ends[1]}" type="{kind}" spreadType="{spread}"'
    return f'<edge id="{name}" {between} shape="{shape}"/>'


def _add_ring(plain: dict[str, list[str]], place: str, around: Sequence[_Arm]) -> str:
    """Replace a junction by a ring at which its streets end; return its roundabout element."""
    centre, entries = complex(around[0].points[0]), []
    names = [f"{place}_{number}" for number in range(len(around))]
    for name, (street, end) in zip(names, around):
        points = street.points[:: -1 if end else 1]
        outside = points[np.argmax(np.abs(points - centre) > _RING_M) :]
        entry = centre + _RING_M * (outside[0] - centre) / abs(outside[0] - centre)
        street.points = np.append(entry, outside[1:])[:: -1 if end else 1]
        street.ends[end] = name
        entries.append(entry)
        plain["nodes"].append(_node(name, entry, "priority", _ENTRY_M))
    for pair, ends in zip(zip(entries, np.roll(entries, -1)), zip(names, names[1:] + names[:1])):
        entry, following = pair
        turn_rad = np.angle((following - centre) / (entry - centre)) % (2.0 * np.pi)
        turns = np.exp(1j * np.linspace(0.0, turn_rad, _RING_POINTS))
        arc = centre + (entry - centre) * turns
        plain["edges"].append(_edge(f"r{ends[0]}", ends, arc, "ring", "center"))
    nodes = " ".join(f"n{name}" for name in names)
    edges = " ".join(f"r{name}" for name in names)
    return f'<roundabout nodes="{nodes}" edges="{edges}"/>'
