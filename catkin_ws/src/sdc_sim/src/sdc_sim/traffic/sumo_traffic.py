"""Other road users, which SUMO moves in this process (libsumo): docs/traffic.md.

The world steps SUMO with its own tick and moves its car among SUMO's vehicles. SUMO's position of a
vehicle is the middle of its front, and its angle is clockwise from north in degrees.
"""

from __future__ import annotations

import contextlib
import importlib
import itertools
import math
import os
import random
from typing import AbstractSet, Any, Iterable, Iterator, NamedTuple

import numpy as np

from sdc_common.configuration import how_to_install
from sdc_common.geometry.route import Route
from sdc_common.validation import DocumentError
from sdc_map.crossings import places_along
from sdc_map.mirror import negated
from sdc_map.network import edge_of
from sdc_map.network_file import load_network
from sdc_sim.physics.collision import Rectangle, overlap
from sdc_sim.physics.obstacles import FIRST_TRAFFIC_ID, ObstacleState
from sdc_sim.yaml_document import config_path

_EGO = "ego"
_PEDESTRIAN = "pedestrian"
# These distances are longer by that in which the car stops gently. No road user begins where it, or
# the car, could not brake gently before the other.
_NEAR_M = 300.0  # road users begin within this distance of the car
_FAR_M = 500.0  # road users farther from the car are replaced
_CLEAR_M = 40.0  # no road user begins closer to the car
_SIGHT_M = 100.0  # none begins in this sight of the car while it drives, if there are other streets
_GENTLE_MPS2 = 3.0
_AROUND_M = 0.2  # who would walk into a standing car leaves the road so far before it
_ROUTE_EDGES = 80  # longest route; it may end before at a dead end
_PATIENCE_S = 20.0  # who has waited so long in a lane that leads elsewhere drives there
_PLACES = 4  # number of places to which a pedestrian walks
_SHORTEST_EDGE_M = 15.0
_ON_ROUTE_M = 2.0  # the car is on its route within this distance
_EXPECTED_EDGES = 3  # number of edges on which others expect a car that is off its route
_MOST_BETWEEN = 4  # most edges of the connection between two edges of a way
_BRAKE_LIGHT = 8
# Types of the programs of lights with fixed times, of rail signals and of rail crossings.
_FIXED_LIGHTS = (0, 1, 2)
_NOWHERE_M = -1e8
_OPTIONS = (
    *("--no-step-log", "--no-warnings", "--xml-validation", "never", "--duration-log.disable"),
    # Road users neither vanish in a jam, nor stop where SUMO's own model sees a collision.
    *("--time-to-teleport", "-1", "--collision.action", "none", "--ignore-route-errors"),
    # They move to the next lane in this time [s], and do not jump there in a tick.
    *("--lanechange.duration", "2"),
    # One that waits takes ever smaller gaps, the smallest ones after this time [s].
    *("--time-to-impatience", "60"),
)


class Kind(NamedTuple):
    """A vehicle type of SUMO: kind of obstacle, class of SUMO, share, length, width, height [m]."""

    kind: str
    vehicle_class: str
    share: float
    size_m: tuple[float, float, float]


class Streets(NamedTuple):
    """The edges for a class of SUMO: middles (N, 2) [m], lengths (N,) [m], what follows each."""

    edges: list[str]
    middles_m: np.ndarray
    lengths_m: np.ndarray
    following: dict[str, list[str]]


class SumoTraffic:
    """Keeps a number of road users on the streets around the car.

    libsumo has one simulation per process: a world that is started later in the same program ends
    the traffic of this one.

    Args:
        net_path: SUMO's network of the map
        count: number of road users
        seed: seed of routes and behaviour
        tick_s: duration of a tick [s]
        mission: edges that the car begins to drive along: the others know where it turns
        is_mirror: whether the map is the mirror image of SUMO's network, with traffic on the left

    Raises:
        DocumentError: libsumo is not installed, or SUMO refuses the network
    """

    _current: SumoTraffic | None = None

    def __init__(
        self,
        net_path: str,
        count: int,
        seed: int,
        tick_s: float,
        mission: Iterable[str],
        is_mirror: bool = False,
    ) -> None:
        self._sumo = sumo = _libsumo()
        self._count, self._seed, self._is_mirror = count, seed, is_mirror
        self._options = ["-n", net_path, "--additional-files", config_path("traffic.add.xml")]
        self._options += ["--step-length", repr(tick_s), "--seed", str(seed % 2**31), *_OPTIONS]
        self._start()
        kinds = {name: self._kind(name) for name in sumo.vehicletype.getIDList()}
        self._kinds = {name: kind for name, kind in kinds.items() if kind.share}
        classes = {kind.vehicle_class for kind in self._kinds.values()}
        self._streets = {name: self._streets_for(name) for name in sorted(classes)}
        if not any(name[0] == ":" and "_w" in name for name in sumo.edge.getIDList()):
            del self._streets[_PEDESTRIAN]  # no way for them across the junctions
        self._kinds = {
            name: kind for name, kind in self._kinds.items() if kind.vehicle_class in self._streets
        }
        self._mission = self._connected(mission)
        read = importlib.import_module("traci.constants")
        self._read = read.VAR_POSITION3D, read.VAR_ANGLE, read.VAR_SPEED, read.VAR_SLOPE

    def reset(self, ego: Rectangle) -> list[ObstacleState]:
        """Start again with the car at this place, and return the road users."""
        self._start()
        self._random = random.Random(self._seed)
        self._users: dict[str, Kind] = {}
        self._next_id = FIRST_TRAFFIC_ID
        self._held: AbstractSet[int] = frozenset()
        self._sumo.route.add(_EGO, self._mission)
        ego = self._mirrored(ego)
        self._add_ego(ego)
        return self._step(ego, 0.0, False, _CLEAR_M)

    def advance(
        self, ego: Rectangle, speed_mps: float, braking: bool, blocked: AbstractSet[int]
    ) -> list[ObstacleState]:
        """Move the road users for a tick, and return them.

        Args:
            ego: outline of the car
            speed_mps: its speed [m/s]
            braking: whether its brake lights are on
            blocked: ids of road users that are held because they met the car

        Raises:
            RuntimeError: another world in traffic has been started in this program
        """
        if SumoTraffic._current is not self:
            raise RuntimeError(
                "the traffic of this world has ended, because another world in traffic was started "
                "in the same program; run each in a process of its own"
            )
        for number in sorted(blocked ^ self._held):
            if str(number) in self._users:
                self._domain(str(number)).setSpeed(str(number), 0.0 if number in blocked else -1.0)
        self._held = blocked
        return self._step(self._mirrored(ego), speed_mps, braking)

    def _mirrored(self, body: Any) -> Any:
        """Return an outline or a state of the map in SUMO's network, or the other way round."""
        return negated(body, "y_m", "yaw_rad") if self._is_mirror else body

    def _start(self) -> None:
        SumoTraffic._current = self
        try:
            if self._sumo.isLoaded():
                self._sumo.load(self._options)
            else:
                self._sumo.start(["sumo", *self._options])
        except self._sumo.TraCIException as error:
            raise DocumentError(f"{self._options[1]}: SUMO refuses the network: {error}") from None
        lights = self._sumo.trafficlight
        for name in lights.getIDList():
            program = lights.getAllProgramLogics(name)[0]
            # Others would follow the traffic, and not the phases of the map; rails have none.
            if program.type not in _FIXED_LIGHTS:
                program.type = 0
                lights.setProgramLogic(name, program)
                lights.setPhase(name, 0)
                lights.setPhaseDuration(name, program.phases[0].duration)

    def _kind(self, name: str) -> Kind:
        types = self._sumo.vehicletype
        size = types.getLength(name), types.getWidth(name), types.getHeight(name)
        share = float(types.getParameter(name, "share") or 0.0)
        return Kind(name.partition(".")[0], types.getVehicleClass(name), share, size)

    def _streets_for(self, vehicle_class: str) -> Streets:
        lanes = self._sumo.lane
        names = (name for name in lanes.getIDList() if name[0] != ":")
        usable = dict.fromkeys(name for name in names if self._may_use(name, vehicle_class))
        following: dict[str, dict[str, str]] = {}
        place = {}
        for name in usable:
            edge, shape = edge_of(name), lanes.getShape(name)
            place[edge] = (*shape[len(shape) // 2], lanes.getLength(name))
            links = [link for link in lanes.getLinks(name) if link[0] in usable]
            following.setdefault(edge, {}).update({edge_of(link[0]): link[6] for link in links})
        edges = [edge for edge, (_, _, length_m) in place.items() if length_m > _SHORTEST_EDGE_M]
        places = np.array([place[edge] for edge in edges]).reshape(-1, 3)
        ordered = {}
        for edge, after in following.items():  # straight on first, and back where nothing else is
            ways = [link for link, way in after.items() if way not in "tT"] or after
            ordered[edge] = sorted(ways, key=lambda link: (after[link] != "s", link))  # noqa: B023
        return Streets(edges, places[:, :2], places[:, 2], ordered)

    def _may_use(self, lane: str, vehicle_class: str) -> bool:
        allowed, refused = self._sumo.lane.getAllowed(lane), self._sumo.lane.getDisallowed(lane)
        return vehicle_class in allowed if allowed else vehicle_class not in refused

    def _connected(self, edges: Iterable[str]) -> list[str]:
        """Return a route over edges, with the short ones between that no point of the way is on."""
        route: list[str] = []
        for edge in edges:
            between = self._sumo.simulation.findRoute((route or [edge])[-1], edge).edges
            if not 0 < len(between) <= _MOST_BETWEEN:
                break
            route += between[bool(route) :]
        return route or self._streets["passenger"].edges[:1]

    def _step(
        self, ego: Rectangle, speed_mps: float, braking: bool, sight_m: float = _SIGHT_M
    ) -> list[ObstacleState]:
        self._move_ego(ego, speed_mps, braking)
        stopping_m = speed_mps**2 / (2.0 * _GENTLE_MPS2)
        begin_m = sight_m + stopping_m, _NEAR_M + stopping_m
        for _ in range(self._count - len(self._users)):
            self._add(ego, begin_m)
        self._sumo.simulationStep()
        simulation, states = self._sumo.simulation, []
        begun = {*simulation.getDepartedIDList(), *simulation.getDepartedPersonIDList()}
        for name in (*simulation.getArrivedIDList(), *simulation.getArrivedPersonIDList()):
            if name == _EGO:
                self._add_ego(ego)  # at the end of its route
            self._users.pop(name, None)
        for domain in (self._sumo.vehicle, self._sumo.person):
            for name, row in domain.getAllSubscriptionResults().items():
                state = self._state(int(name), self._users[name], *map(row.get, self._read))
                if state.x_m < _NOWHERE_M:
                    continue  # It waits for room on its street.
                distance_m = math.hypot(state.x_m - ego.x_m, state.y_m - ego.y_m)
                room_m = _CLEAR_M + max(stopping_m, state.speed_mps**2 / (2.0 * _GENTLE_MPS2))
                leaves = distance_m > _FAR_M + stopping_m or (name in begun and distance_m < room_m)
                if not speed_mps and domain is self._sumo.person:
                    leaves = leaves or bool(overlap(state.rectangle, ego.grown(_AROUND_M)))
                if leaves:
                    domain.unsubscribe(name)
                    domain.remove(name)
                    del self._users[name]
                else:
                    states.append(self._mirrored(state))
                    if domain is self._sumo.vehicle and domain.getWaitingTime(name) > _PATIENCE_S:
                        self._leave_queue(name)
        return states

    def _add_ego(self, ego: Rectangle) -> None:
        vehicle = self._sumo.vehicle
        vehicle.add(_EGO, _EGO)
        vehicle.setLength(_EGO, ego.length_m)
        vehicle.setWidth(_EGO, ego.width_m)
        vehicle.setSpeedMode(_EGO, 0)
        vehicle.setLaneChangeMode(_EGO, 0)
        self._off_route = False

    def _move_ego(self, ego: Rectangle, speed_mps: float, braking: bool) -> None:
        """Move our car among the vehicles, on its route if it is there: they know where it turns.

        Elsewhere they expect that it drives straight on.
        """
        vehicle, front_m = self._sumo.vehicle, 0.5 * ego.length_m
        x_m = ego.x_m + front_m * math.cos(ego.yaw_rad)
        y_m = ego.y_m + front_m * math.sin(ego.yaw_rad)
        if self._off_route:
            route = [self._sumo.simulation.convertRoad(x_m, y_m, False, "passenger")[0]]
            following = self._streets["passenger"].following
            while len(route) < _EXPECTED_EDGES and following.get(route[-1]):
                route.append(following[route[-1]][0])
            with contextlib.suppress(self._sumo.TraCIException):  # between two edges
                vehicle.setRoute(_EGO, route)
        place = "", -1, x_m, y_m, 90.0 - math.degrees(ego.yaw_rad)
        if self._has_passed_one():  # for a tick, it is nowhere, and then inserted in the new order
            vehicle.moveToXY(_EGO, "", -1, _NOWHERE_M, _NOWHERE_M, 0.0, 2)
            return
        try:
            vehicle.moveToXY(_EGO, *place, 1, _ON_ROUTE_M)
            self._off_route = False
        except self._sumo.TraCIException:
            vehicle.moveToXY(_EGO, *place, 2)
            self._off_route = True
        vehicle.setPreviousSpeed(_EGO, max(speed_mps, 0.0))
        vehicle.setSignals(_EGO, _BRAKE_LIGHT if braking else 0)

    def _has_passed_one(self) -> bool:
        """Return whether the car is before one on its lane that SUMO has still before the car."""
        vehicle = self._sumo.vehicle
        lane = vehicle.getLaneID(_EGO)
        names = self._sumo.lane.getLastStepVehicleIDs(lane) if lane else ()
        places_m = [vehicle.getLanePosition(name) for name in names]
        return places_m != sorted(places_m)

    def _state(  # noqa: PLR0913  a row of SUMO
        self, number: int, kind: Kind, front: Any, angle: float, mps: float, slope: float
    ) -> ObstacleState:
        yaw_rad = math.radians(90.0 - angle)
        pitch_rad = -math.radians(slope) if math.isfinite(slope) else 0.0
        back_m = 0.5 * kind.size_m[0]
        front_x_m, front_y_m, front_z_m = (*front, 0.0)[:3]  # one that waits has no height
        x_m = front_x_m - back_m * math.cos(yaw_rad)
        y_m = front_y_m - back_m * math.sin(yaw_rad)
        # SUMO's speed of a pedestrian at the edge of a walking area is sometimes NaN.
        speed_mps = max(mps, 0.0) if math.isfinite(mps) else 0.0
        place = x_m, y_m, yaw_rad, *kind.size_m, speed_mps, front_z_m + back_m * math.tan(pitch_rad)
        return ObstacleState(number, kind.kind, *place, pitch_rad)

    def _domain(self, name: str) -> Any:
        is_person = self._users[name].vehicle_class == _PEDESTRIAN
        return self._sumo.person if is_person else self._sumo.vehicle

    def _add(self, ego: Rectangle, begin_m: tuple[float, float]) -> None:
        """Add a road user of a drawn kind on a street between two distances of the car [m]."""
        shares = [kind.share for kind in self._kinds.values()]
        drawn = self._random.choices(list(self._kinds), shares)[0]
        kind = self._kinds[drawn]
        streets = self._streets[kind.vehicle_class]
        name, edge = str(self._next_id), self._drawn_edge(streets, ego, *begin_m)
        if kind.vehicle_class == _PEDESTRIAN:
            walks = list(self._walks(streets, ego, edge, begin_m[1]))
            if not walks:
                return
            self._sumo.person.add(name, edge, 0.0, typeID=drawn)
            for walk in walks:
                self._sumo.person.appendStage(name, walk)
        else:
            self._sumo.route.add(name, self._route(streets, edge))
            place = {"departLane": "free", "departPos": "random_free", "departSpeed": "max"}
            self._sumo.vehicle.add(name, name, drawn, **place)
        self._users[name] = kind
        self._next_id += 1
        self._domain(name).subscribe(name, self._read)

    def _route(self, streets: Streets, *edges: str) -> list[str]:
        """Return a drawn way that begins with these edges."""
        route = [*edges]
        while len(route) < _ROUTE_EDGES and streets.following[route[-1]]:
            route.append(self._random.choice(streets.following[route[-1]]))
        return route

    def _leave_queue(self, name: str) -> None:
        """Let one that waits for another lane go where its own lane leads.

        Two that wait for the lanes of each other would wait for ever, with all behind them.
        """
        vehicle, streets = self._sumo.vehicle, self._streets[self._users[name].vehicle_class]
        ahead = vehicle.getRoute(name)[vehicle.getRouteIndex(name) :]
        links = self._sumo.lane.getLinks(vehicle.getLaneID(name))
        ways = {edge_of(link[0]) for link in links} & {*streets.following.get(ahead[0], ())}
        if ahead[1:] and ways and ahead[1] not in ways:
            vehicle.setRoute(name, self._route(streets, ahead[0], min(ways)))

    def _drawn_edge(self, streets: Streets, ego: Rectangle, from_m: float, until_m: float) -> str:
        distance_m = np.hypot(*(streets.middles_m - (ego.x_m, ego.y_m)).T)
        weights = streets.lengths_m * ((distance_m > from_m) & (distance_m < until_m))
        if not weights.any():
            weights = streets.lengths_m
        return self._random.choices(streets.edges, weights.tolist())[0]

    def _walks(self, streets: Streets, ego: Rectangle, edge: str, until_m: float) -> Iterator[Any]:
        for _ in range(_PLACES):
            end = self._drawn_edge(streets, ego, 0.0, until_m)
            walks = self._sumo.simulation.findIntermodalRoute(edge, end) if end != edge else ()
            for walk in walks:
                yield walk
                edge = end


def of_map(path: str, count: int, seed: int, tick_s: float, mission_m: np.ndarray) -> SumoTraffic:
    """Return the traffic on a map; see SumoTraffic."""
    network = load_network(path)
    route = Route(mission_m * (1.0, network.y_sign))
    lanes = (place.lane for _, place in places_along(network.right_hand, route))
    edges = (edge for edge, _ in itertools.groupby(map(edge_of, lanes)) if edge[0] != ":")
    return SumoTraffic(network.net_path, count, seed, tick_s, edges, network.y_sign < 0.0)


def _libsumo() -> Any:
    # Without it, libsumo warns of data that it does not need.
    os.environ.setdefault("SUMO_HOME", config_path(""))
    try:
        return importlib.import_module("libsumo")
    except ImportError as error:
        fix = how_to_install("traffic")
        raise DocumentError(f"traffic: libsumo cannot be imported ({error}); {fix}") from None
