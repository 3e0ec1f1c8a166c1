"""Draw a town that is new to every driver from a seed.

SUMO's netgenerate draws where streets run: a grid, a spider's web or a random net. Here the net
becomes a town: some streets are removed, the others get a kind (lanes and limit) along their whole
length and bend, and junctions get lights, signs, right before left or a roundabout. netconvert
makes the network of it, with the options of the packaged town.

Points of the plan are complex numbers x + yi [m], so that a turn is a product.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple, Sequence

import numpy as np

from sdc_map.sumo_programs import MapError, cached, run
from sdc_map.yellow import lengthen_yellow

_LEFT_HAND_SHARE = 0.25  # of the towns
_LARGEST_SEED = 4294967295
# A change of the drawing is another version of each town.
_VERSION = Path(__file__).read_bytes()
_FIX = "report the seed, and take another one"
# Points along a street are so far apart [m].
_STEP_M = 2.0
# Two streets are at least so far apart, farther than this from a junction that they share [m].
_APART_M = 40.0
_NEAR_M = 55.0
# Least angle between two streets at a junction, and at a roundabout [rad].
_LEAST_RAD = np.radians(50.0)
_ROUNDABOUT_RAD = np.radians(65.0)
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
# A corner between two junctions is rounded over at most this distance before and after it [m].
_ROUND_M = 240.0
# Share of the length by which a street bows to one side at most.
_BOW = 0.1
_HIGHEST_BOW_M = 30.0


class StreetKind(NamedTuple):
    """A kind of street, a type of SUMO's plain XML."""

    name: str
    lanes: int  # in each direction
    limit_kmh: int
    sidewalk: bool
    length_m: float  # least length of the whole street
    block_m: float  # least distance between two junctions
    radius_m: float  # least radius of a bend


# In the order of right of way.
KINDS = (
    StreetKind("lane", 1, 30, True, 0.0, 0.0, 0.0),
    StreetKind("street", 1, 50, True, 150.0, 0.0, 20.0),
    StreetKind("avenue", 2, 50, True, 300.0, 80.0, 40.0),
    StreetKind("boulevard", 3, 60, True, 400.0, 100.0, 60.0),
    StreetKind("parkway", 2, 70, True, 400.0, 140.0, 90.0),
    StreetKind("road", 1, 80, False, 200.0, 180.0, 100.0),
    StreetKind("highway", 2, 100, False, 300.0, 250.0, 180.0),
    StreetKind("motorway", 3, 120, False, 350.0, 300.0, 280.0),
)
# A street is of one of so many kinds, the fastest for which it is long and straight enough.
_CHOICES = 5
_STREET = KINDS[1]


@dataclass(eq=False)
class Street:
    """A street between two junctions."""

    name: str  # in the other direction, it begins with a minus
    start: str
    end: str
    points: np.ndarray = field(repr=False)  # (N,) from start to end [m]
    kind: StreetKind = _STREET

    @property
    def length_m(self) -> float:
        """Length [m]."""
        return float(np.abs(np.diff(self.points)).sum())

    def reversed(self) -> Street:
        """Return the street from its end to its start."""
        name = self.name[1:] if self.name[0] == "-" else f"-{self.name}"
        return Street(name, self.end, self.start, self.points[::-1], self.kind)


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
        streets: list[Street] = []
        while len(_arms(streets)) < _LEAST_JUNCTIONS:
            streets = _pruned(_thinned(random, _net(random, name, folder)))
        streets = _bent(random, _with_kinds(random, streets))
        _Plain(random, streets).write(os.path.join(folder, "town"))
        run("netconvert", arguments, out, name, _FIX)
    tree = ElementTree.parse(out)  # It leaves out the comment with the time of day.
    lengthen_yellow(tree.getroot())
    tree.write(out)
    if is_left:
        right = f"{name}_right.net.xml"
        os.rename(out, os.path.join(made, right))
        Path(out).write_text(f'<net lefthand="true" mirrorOf="{right}"/>\n', encoding="utf-8")


def _net(random: np.random.Generator, name: str, folder: str) -> list[Street]:
    """Return the straight streets of a net of netgenerate, turned and stretched."""
    size = [str(number) for number in random.integers(4, 7, 2)]
    block_m = 100.0 * 3.0 ** random.random()
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
    ids = {
        node.get("id", ""): complex(*(float(node.get(axis, 0)) for axis in "xy")) for node in nodes
    }
    plan = np.array(list(ids.values()))
    plan -= 0.5 * (plan.real.max() + plan.real.min() + 1j * (plan.imag.max() + plan.imag.min()))
    # Blocks are longer outside.
    plan = _stretched(random, plan.real) + 1j * _stretched(random, plan.imag)
    shift = random.uniform(-1.0, 1.0, (2, len(plan))) * random.uniform(0.0, 0.1) * block_m
    plan = (plan + shift[0] + 1j * shift[1]) * np.exp(1j * random.uniform(0.0, np.pi))
    points = dict(zip(ids, plan))
    edges = ElementTree.parse(prefix + ".edg.xml").iter("edge")
    pairs = sorted({tuple(sorted((edge.get("from", ""), edge.get("to", "")))) for edge in edges})
    return [
        Street(f"s{number}", a, b, np.array([points[a], points[b]]))
        for number, (a, b) in enumerate(pairs)
    ]


def _stretched(random: np.random.Generator, x: np.ndarray) -> np.ndarray:
    return x * (1.0 + random.uniform(0.0, 1.2) * (x / max(np.abs(x).max(), 1.0)) ** 2)


def _from(street: Street, place: str) -> Street:
    return street if street.start == place else street.reversed()


def _arms(streets: Sequence[Street]) -> dict[str, list[Street]]:
    """Return the streets at each junction, each from there, by direction."""
    arms: dict[str, list[Street]] = {}
    for street in streets:
        for arm in (street, street.reversed()):
            arms.setdefault(arm.start, []).append(arm)
    for around in arms.values():
        around.sort(key=lambda arm: float(np.angle(arm.points[1] - arm.points[0])))
    return arms


def _gaps_rad(around: Sequence[Street]) -> np.ndarray:
    """Return the angle from each street at a junction to the next one [rad]."""
    turns = np.array([arm.points[1] - arm.points[0] for arm in around])
    gaps = np.angle(np.roll(turns, -1) / turns) % (2.0 * np.pi)
    return gaps if len(gaps) > 1 else np.array([2.0 * np.pi])


def _sampled(points: np.ndarray) -> np.ndarray:
    s = np.append(0.0, np.cumsum(np.abs(np.diff(points))))
    at = np.linspace(0.0, s[-1], int(s[-1] / _STEP_M) + 2)
    return np.interp(at, s, points.real) + 1j * np.interp(at, s, points.imag)


def _is_apart(street: Street, other: Street) -> bool:
    """Return whether two streets are apart, except near a junction that they share."""
    reach_m = 0.5 * (street.length_m + other.length_m) + _APART_M
    if (
        abs(street.points[0] + street.points[-1] - other.points[0] - other.points[-1])
        > 4.0 * reach_m
    ):
        return True
    points, others = _sampled(street.points), _sampled(other.points)
    apart_m = np.abs(points[:, None] - others[None, :])
    for place in {street.start, street.end} & {other.start, other.end}:
        junction = street.points[0 if street.start == place else -1]
        near = np.abs(points - junction) < _NEAR_M, np.abs(others - junction) < _NEAR_M
        apart_m[np.ix_(*near)] = np.inf
    return bool(apart_m.min() > _APART_M)


def _thinned(random: np.random.Generator, streets: Sequence[Street]) -> list[Street]:
    """Return streets without those that come too near to others, and without some more."""
    kept: list[Street] = []
    for number in random.permutation(len(streets)):
        street = streets[number]
        ends = {street.start, street.end}
        arms = _arms([street, *(other for other in kept if ends & {other.start, other.end})])
        sharp = min(_gaps_rad(arms[place]).min() for place in ends)
        if sharp > _LEAST_RAD and all(_is_apart(street, other) for other in kept):
            kept.append(street)
    share = random.uniform(0.0, 0.3)
    for street in kept[: int(share * len(kept))]:
        arms = _arms(kept)
        if min(len(arms[street.start]), len(arms[street.end])) > 3:
            kept.remove(street)
    return kept


def _pruned(streets: list[Street]) -> list[Street]:
    """Return streets without dead ends and loops; two that only meet each other become one.

    If that one would bend too sharply, both are removed.
    """
    while True:
        arms = _arms(streets)
        loops = [street for street in streets if street.start == street.end]
        ends = [around for around in arms.values() if len(around) < 3]
        if not (loops or ends):
            return streets
        for removed in loops[:1] or ends[0]:
            streets = [street for street in streets if not _is_same(street, removed)]
        if not loops and len(ends[0]) == 2:
            before, after = ends[0][0].reversed(), ends[0][1]
            points = np.append(before.points, after.points[1:])
            if _least_radius_m(_rounded(points)) > _LEAST_RADIUS_M:
                streets.append(Street(before.name, before.start, after.end, points))


def _is_same(street: Street, other: Street) -> bool:
    return street.name.lstrip("-") == other.name.lstrip("-")


def _rounded(points: np.ndarray) -> np.ndarray:
    """Return a line whose corners are rounded, by a moving average of it, twice."""
    if len(points) == 2:
        return _sampled(points)
    reach_m = min(_ROUND_M, 0.9 * np.abs(np.diff(points))[[0, -1]].min())
    count = max(int(reach_m / _STEP_M), 1)
    line = _sampled(points)
    steps = np.arange(1, count + 1)
    before = line[0] - steps[::-1] * (line[1] - line[0])
    after = line[-1] + steps * (line[-1] - line[-2])
    kernel = np.convolve(np.ones(count), np.ones(count + 1)) / (count * (count + 1))
    return np.convolve(np.concatenate([before, line, after]), kernel, "valid")


def _least_radius_m(points: np.ndarray) -> float:
    steps = np.diff(points)
    turns = np.abs(np.angle(steps[1:] / steps[:-1]))
    return float((np.abs(steps[1:]) / np.maximum(turns, 1e-6)).min())


def _with_kinds(random: np.random.Generator, streets: Sequence[Street]) -> list[Street]:
    """Return rounded streets, each with a kind, which is the same where it goes on at junctions."""
    rounded = [replace(street, points=_rounded(street.points)) for street in streets]
    whole = list(range(len(rounded)))  # the number of the whole street of each
    turns = [0.0] * len(rounded)  # the greatest turn of each at its ends [rad]
    for place in sorted({name for street in rounded for name in (street.start, street.end)}):
        own = [n for n, street in enumerate(rounded) if place in (street.start, street.end)]
        ways = [_from(rounded[number], place).points for number in own]
        pairs = [
            (abs(float(np.angle((way[1] - way[0]) / (back[0] - back[1])))), own[i], own[j])
            for i, way in enumerate(ways)
            for j, back in enumerate(ways[:i])
        ]
        for turn_rad, i, j in sorted(pairs):
            if turn_rad < _ON_RAD and {i, j} <= set(own):
                own = [number for number in own if number not in (i, j)]
                turns[i], turns[j] = max(turns[i], turn_rad), max(turns[j], turn_rad)
                whole = [whole[i] if number == whole[j] else number for number in whole]
    for number in sorted(set(whole)):
        parts = [index for index, own_number in enumerate(whole) if own_number == number]
        blocks_m = [rounded[index].length_m for index in parts]
        radius_m = min(_least_radius_m(rounded[index].points) for index in parts)
        radius_m = min(radius_m, _ON_M / max(1e-9, *(turns[index] for index in parts)))
        fits = [
            kind
            for kind in KINDS
            if sum(blocks_m) >= kind.length_m
            and min(blocks_m) >= kind.block_m
            and radius_m >= kind.radius_m
        ][-_CHOICES:]
        kind = fits[random.integers(len(fits))]
        for index in parts:
            rounded[index].kind = kind
    return rounded


def _bent(random: np.random.Generator, streets: list[Street]) -> list[Street]:
    """Return streets of which some bow to a side or wind, if they remain apart."""
    for index, street in enumerate(streets):
        count, length_m = len(street.points), street.length_m
        share, winds = random.uniform(-1.0, 1.0), int(random.integers(2))
        height_m = share * min(_BOW * length_m, _HIGHEST_BOW_M)
        if random.random() < 0.4:
            continue
        t = np.linspace(0.0, np.pi, count)
        normals = 1j * np.gradient(street.points)
        offsets = height_m * np.sin(t) ** 2 * np.cos(winds * t)
        bent = replace(street, points=street.points + offsets * normals / np.abs(normals))
        is_smooth = _least_radius_m(bent.points) > max(street.kind.radius_m, _LEAST_RADIUS_M)
        if is_smooth and all(_is_apart(bent, other) for other in streets if other is not street):
            streets[index] = bent
    return streets


class _Plain:
    """A town in SUMO's plain XML.

    Args:
        random: draws the kinds of the junctions
        streets: the streets
    """

    def __init__(self, random: np.random.Generator, streets: Sequence[Street]) -> None:
        self._random, self._streets = random, list(streets)
        self._nodes: list[str] = []
        self._edges: list[str] = []
        self._rings: list[str] = []
        self._crossings: list[str] = []
        for place in sorted(_arms(streets)):
            around = _arms(self._streets)[place]
            kind = _junction(random, around)
            if kind == "roundabout":
                self._add_ring(place, around)
            else:
                self._add_node(place, around[0].points[0], kind, _CORNER_M)
                self._add_crossings(place, around, kind)
        for street in self._streets:
            self._add_edge(street, street.kind.name)
            self._add_edge(street.reversed(), street.kind.name)

    def _add_node(self, name: str, place: complex, kind: str, radius_m: float) -> None:
        at = f'x="{place.real:.3f}" y="{place.imag:.3f}" type="{kind}" radius="{radius_m:g}"'
        self._nodes.append(f'<node id="n{name}" {at}/>')

    def _add_edge(self, street: Street, kind: str, spread: str = "right") -> None:
        shape = " ".join(f"{point.real:.3f},{point.imag:.3f}" for point in street.points)
        ends = f'from="n{street.start}" to="n{street.end}" type="{kind}" spreadType="{spread}"'
        self._edges.append(f'<edge id="{street.name}" {ends} shape="{shape}"/>')

    def _add_crossings(self, place: str, around: Sequence[Street], kind: str) -> None:
        has_lights = kind == "traffic_light"
        more = "" if has_lights else ' priority="true"'
        for arm in around:
            is_slow = arm.kind.limit_kmh <= _STREET.limit_kmh
            is_drawn = self._random.random() < _CROSSED_SHARE
            if arm.kind.sidewalk and (has_lights or is_slow and is_drawn):
                edges = f"{arm.name} {arm.reversed().name}"
                self._crossings.append(f'<crossing node="n{place}" edges="{edges}"{more}/>')

    def _add_ring(self, place: str, around: Sequence[Street]) -> None:
        """Replace a junction by a ring at which its streets end."""
        centre, entries = around[0].points[0], []
        for number, arm in enumerate(around):
            outside = arm.points[np.argmax(np.abs(arm.points - centre) > _RING_M) :]
            entries.append(centre + _RING_M * (outside[0] - centre) / abs(outside[0] - centre))
            points = np.append(entries[-1], outside[1:])
            cut = replace(arm, start=f"{place}_{number}", points=points)
            self._streets = [cut if _is_same(street, arm) else street for street in self._streets]
            self._add_node(cut.start, entries[-1], "priority", _ENTRY_M)
        for number, entry in enumerate(entries):
            following = (number + 1) % len(entries)
            turn_rad = np.angle((entries[following] - centre) / (entry - centre)) % (2.0 * np.pi)
            turns = np.exp(1j * np.linspace(0.0, turn_rad, _RING_POINTS))
            ends = f"{place}_{number}", f"{place}_{following}"
            arc = Street(f"r{ends[0]}", *ends, centre + (entry - centre) * turns)
            self._add_edge(arc, "ring", "center")
        numbers = range(len(around))
        nodes = " ".join(f"n{place}_{number}" for number in numbers)
        edges = " ".join(f"r{place}_{number}" for number in numbers)
        self._rings.append(f'<roundabout nodes="{nodes}" edges="{edges}"/>')

    def write(self, prefix: str) -> None:
        """Write the four files of the town; their names begin with a prefix."""
        types = [
            f'<type id="{kind.name}" priority="{rank}" numLanes="{kind.lanes}" width="3.5" '
            f'speed="{kind.limit_kmh / 3.6:.2f}" '
            + ('sidewalkWidth="2.0"/>' if kind.sidewalk else 'disallow="pedestrian"/>')
            for rank, kind in enumerate(KINDS, 1)
        ]
        types.append('<type id="ring" priority="9" speed="8.33" width="4" disallow="pedestrian"/>')
        files = {
            "nodes": self._nodes,
            "edges": self._edges + self._rings,
            "connections": self._crossings,
            "types": types,
        }
        for root, lines in files.items():
            ending = {"edges": "edg"}.get(root, root[:3])
            with open(f"{prefix}.{ending}.xml", "w", encoding="utf-8") as file:
                file.write("\n".join([f"<{root}>", *lines, f"</{root}>", ""]))


def _junction(random: np.random.Generator, around: Sequence[Street]) -> str:
    """Return the kind of a junction: a type of SUMO, or "roundabout"."""
    ranks = sorted(KINDS.index(arm.kind) for arm in around)
    fastest_kmh = max(arm.kind.limit_kmh for arm in around)
    most_lanes = max(arm.kind.lanes for arm in around)
    draw, other = random.random(2)
    has_room = _gaps_rad(around).min() > _ROUNDABOUT_RAD
    if has_room and most_lanes == 1 and fastest_kmh <= _STREET.limit_kmh and draw < 0.35:
        return "roundabout"
    if ranks[-1] == 0:
        return "right_before_left" if other < 0.75 else "allway_stop"
    # With more than four streets, a light is red for too long.
    can_have_lights = fastest_kmh <= 70 and ranks[-2] >= 1 and len(around) <= 4
    if can_have_lights and draw < (0.85 if most_lanes > 1 else 0.3):
        return "traffic_light"
    return "priority" if other < 0.7 else "priority_stop"
