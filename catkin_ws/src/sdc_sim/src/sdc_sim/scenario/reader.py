"""Reads scenarios: what a drive is like, and what it must keep. The format stands in scenarios/README.md."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field

import numpy as np

from sdc_common.geometry.route import Route
from sdc_sim.physics.obstacles import KINDS, ObstaclePlan
from sdc_sim.physics.traffic_lights import COLOURS, TrafficLightPlan
from sdc_sim.road.route_generator import ELEMENTS, RouteSpecError, check
from sdc_sim.scenario.acceptance_limits import (
    FIGURES,
    INFRACTIONS,
    STATUSES,
    AcceptanceLimits,
    RequiredStop,
)
from sdc_sim.scenario.yaml_reader import ScenarioError, YamlReader, read_text

FASTEST_MPS = 60.0
FARTHEST_M = 1e5
LARGEST_M = 50.0
LONGEST_S = 1e6

# The lines of config/sim.yaml that a scenario may set, with their ranges. Whole numbers stay whole.
SIM_NUMBERS = {
    "seed": (0, 2**32 - 1),
    "friction": (0.05, 2.0),
    "side_wind_mps": (-40.0, 40.0),
    "sensor_latency_s": (0.0, 2.0),
    "command_latency_s": (0.0, 2.0),
    "daylight": (0.0, 1.0),
    "unstamped_patience_s": (0.001, 10.0),
}
SIM_GROUPS = {
    "odometry_noise": {
        "position_m": (0.0, 5.0),
        "heading_rad": (0.0, 1.0),
        "speed_mps": (0.0, 10.0),
    },
    "start": {
        "along_m": (0.0, FARTHEST_M),
        "left_m": (-50.0, 50.0),
        "turned_rad": (-math.pi, math.pi),
    },
}

_KEYS = (
    "about",
    "route",
    "vehicle",
    "stack",
    "camera",
    *SIM_NUMBERS,
    *SIM_GROUPS,
    "frame",
    "obstacles",
    "lights",
    "limits",
)
_FRAMES = ("map", "route")
_OBSTACLE_KEYS = ("kind", "at", "yaw_rad", "path", "speed_mps", "start_s", "trigger_m", "size_m")
_LIGHT_KEYS = ("stop_line_m", "phases", "offset_s")
_LIMIT_KEYS = ("status", "at_most", "at_least", "stops")


@dataclass(frozen=True)
class Scenario:
    """A drive as its file describes it. route: elements of a drawn route, or a name or path; None where the file leaves it open.

    sim: lines of config/sim.yaml. What stands on the road is read by `load_obstacles` and `load_lights`, which need the route.
    """

    path: str
    about: str = ""
    route: object = None
    vehicle: str = None
    stack: str = None
    camera: bool = False
    sim: dict = field(default_factory=dict)
    limits: AcceptanceLimits = field(default_factory=AcceptanceLimits)

    @property
    def name(self) -> str:
        """The file's name without its ending."""
        return os.path.splitext(os.path.basename(self.path))[0]


def load_scenario(path: str) -> Scenario:
    """Read a scenario, but for what stands on the road. Raises ScenarioError."""
    return _Reader(path).scenario()


def load_obstacles(path: str, route: Route) -> list:
    """The Plans of the obstacles in a scenario, or in a file with obstacles alone; none for an empty path. Raises ScenarioError.

    A point is [x, y] in the map with `frame: map`, and [metres along the route, metres to its left] with `frame: route`.
    """
    return _Reader(path, route).plans() if path else []


def load_lights(path: str, route: Route) -> list:
    """The traffic Lights of a scenario; none for an empty path. Raises ScenarioError."""
    return _Reader(path, route).lights() if path else []


class _Reader(YamlReader):
    def __init__(self, path: str, route: Route = None):
        super().__init__(path)
        self.route = route
        root = self.compose(
            read_text(path, "name a readable YAML file (scenario:=, obstacles_path:=)")
        )
        if root is None:
            raise ScenarioError(
                f"{self.path}: is empty; write 'frame: map' and 'obstacles:', or a scenario"
            )
        self.entries = self.mapping(root, _KEYS, "the file")
        if set(self.entries) <= {"frame", "obstacles"} or "obstacles" in self.entries:
            for key in ("frame", "obstacles"):
                if key not in self.entries:
                    raise ScenarioError(
                        f"{self.path}: key '{key}' is missing; add the line '{key}:'"
                    )
        self.by_route = (
            "frame" in self.entries
            and self.word(self.entries["frame"], "frame", _FRAMES) == "route"
        )

    def scenario(self) -> Scenario:
        entries = self.entries
        words = {
            key: self.text(entries[key], key)
            for key in ("about", "vehicle", "stack")
            if key in entries
        }
        for key in ("vehicle", "stack"):
            if key in words and not words[key].isidentifier():
                self.refuse(
                    entries[key],
                    f"'{key}' is {words[key]!r}; write a name of letters, digits and _, no path",
                )
        sim = {
            key: self.setting(entries[key], key, bounds)
            for key, bounds in SIM_NUMBERS.items()
            if key in entries
        }
        for group, known in SIM_GROUPS.items():
            if group in entries:
                parts = self.mapping(entries[group], tuple(known), f"'{group}'")
                sim[group] = {
                    key: self.number(node, key, *known[key]) for key, node in parts.items()
                }
        return Scenario(
            self.path,
            route=self.course(entries["route"]) if "route" in entries else None,
            camera="camera" in entries
            and self.word(entries["camera"], "camera", ("true", "false")) == "true",
            sim=sim,
            limits=self.limits(entries["limits"]) if "limits" in entries else AcceptanceLimits(),
            **words,
        )

    def setting(self, node, key: str, bounds):
        value = self.number(node, key, *bounds)
        if isinstance(bounds[0], int):
            if value != int(value):
                self.refuse(node, f"'{key}' is {node.value}; give a whole number")
            return int(value)
        return value

    def course(self, node):
        """The name or path of a route as it stands there, or the elements of a drawn one."""
        if isinstance(getattr(node, "value", None), str):
            return self.text(node, "route")
        elements = []
        for entry in self.sequence(node, "route", "straight_m: 50"):
            parts = self.mapping(entry, tuple(ELEMENTS), "a part of the route")
            elements.append(
                {key: self.number(part, key, *ELEMENTS[key]) for key, part in parts.items()}
            )
            try:
                check(elements)
            except RouteSpecError as error:
                self.refuse(entry, str(error))
        if not elements:
            self.refuse(node, "'route' has no part; add '- straight_m: 50'")
        return elements

    def limits(self, node) -> AcceptanceLimits:
        entries = self.mapping(node, _LIMIT_KEYS, "'limits'")
        known = (*FIGURES, "infractions", *INFRACTIONS)
        bounds = {}
        for side in ("at_most", "at_least"):
            figures = self.mapping(entries[side], known, f"'{side}'") if side in entries else {}
            bounds[side] = {
                key: self.number(value, key, -1e9, 1e9) for key, value in figures.items()
            }
        stops = []
        for entry in (
            self.sequence(entries["stops"], "stops", "{at_m: 40, within_m: 1}")
            if "stops" in entries
            else []
        ):
            parts = self.mapping(entry, RequiredStop._fields, "a stop")
            for key in RequiredStop._fields:
                if key not in parts:
                    self.refuse(entry, f"a stop has no '{key}'; add it in m")
            stops.append(
                RequiredStop(
                    self.number(parts["at_m"], "at_m", 0.0, FARTHEST_M),
                    self.number(parts["within_m"], "within_m", 0.01, 1e3),
                )
            )
        status = (
            self.word(entries["status"], "status", STATUSES)
            if "status" in entries
            else AcceptanceLimits.status
        )
        return AcceptanceLimits(status, bounds["at_most"], bounds["at_least"], tuple(stops))

    def plans(self) -> list:
        if "obstacles" not in self.entries:
            return []
        return [
            self.plan(node)
            for node in self.sequence(self.entries["obstacles"], "obstacles", "kind: ...")
        ]

    def plan(self, node) -> ObstaclePlan:
        entries = self.mapping(node, _OBSTACLE_KEYS, "an obstacle")
        if "kind" not in entries:
            self.refuse(
                node, f"an obstacle has no 'kind'; add 'kind: ' and one of {', '.join(KINDS)}"
            )
        kind = self.word(entries["kind"], "kind", tuple(KINDS))
        if ("at" in entries) == ("path" in entries):
            self.refuse(
                node,
                "an obstacle needs either 'at: [x, y]' (it stands) or 'path: [[x, y], [x, y]]' (it moves)",
            )
        size = tuple(KINDS[kind][:3])
        if "size_m" in entries:
            size = tuple(self.numbers(entries["size_m"], "size_m", 3, 0.05, LARGEST_M))
        moving = "path" in entries
        for key in ("speed_mps", "start_s", "trigger_m") if not moving else ("yaw_rad",):
            if key in entries:
                self.refuse(
                    entries[key],
                    f"'{key}' belongs to an obstacle with '{'at' if moving else 'path'}'; remove it",
                )
        if moving:
            return self.moving(node, entries, kind, size)
        yaw = self.number(entries["yaw_rad"], "yaw_rad", -7.0, 7.0) if "yaw_rad" in entries else 0.0
        point, heading = self.place(entries["at"], "at")
        return ObstaclePlan(kind, (point,), size, heading + yaw)

    def moving(self, node, entries: dict, kind: str, size: tuple) -> ObstaclePlan:
        if "speed_mps" not in entries:
            self.refuse(node, "an obstacle with 'path' has no 'speed_mps'; add it in m/s")
        if "start_s" in entries and "trigger_m" in entries:
            self.refuse(
                entries["trigger_m"],
                "an obstacle has both 'start_s' and 'trigger_m'; remove one of them",
            )
        path = self.sequence(entries["path"], "path", "[0, 0]")
        if len(path) < 2:
            self.refuse(
                entries["path"],
                "'path' must be a list of two points or more, such as [[0, 0], [5, 0]]",
            )
        points = tuple(self.place(entry, "path")[0] for entry in path)
        for entry, a, b in zip(path[1:], points, points[1:]):
            if math.hypot(b[0] - a[0], b[1] - a[1]) < 1e-3:
                self.refuse(entry, "'path' repeats the point before; remove one of them")
        return ObstaclePlan(
            kind,
            points,
            size,
            speed_mps=self.number(entries["speed_mps"], "speed_mps", 0.01, FASTEST_MPS),
            start_s=self.number(entries["start_s"], "start_s", 0.0, LONGEST_S)
            if "start_s" in entries
            else 0.0,
            trigger_m=self.number(entries["trigger_m"], "trigger_m", 0.1, FARTHEST_M)
            if "trigger_m" in entries
            else None,
        )

    def place(self, node, key: str):
        """A point in the map, and the heading that yaw_rad counts from."""
        first, second = self.numbers(node, key, 2, -FARTHEST_M, FARTHEST_M)
        if not self.by_route:
            return (first, second), 0.0
        x, y, heading = self.on_route(node, key, first)
        return (x - second * math.sin(heading), y + second * math.cos(heading)), heading

    def on_route(self, node, key: str, along_m: float):
        """(x, y, heading) at so many metres along the route."""
        if not 0.0 <= along_m <= self.route.length_m:
            self.refuse(
                node,
                f"'{key}' lies {along_m:g} m along a route of {self.route.length_m:.1f} m; give a place on it",
            )
        return tuple(
            float(np.interp(along_m, self.route.s, values))
            for values in (*self.route.points.T, self.route.heading)
        )

    def lights(self) -> list:
        if "lights" not in self.entries:
            return []
        return [
            self.light(node)
            for node in self.sequence(self.entries["lights"], "lights", "stop_line_m: 50")
        ]

    def light(self, node) -> TrafficLightPlan:
        entries = self.mapping(node, _LIGHT_KEYS, "a light")
        for key in ("stop_line_m", "phases"):
            if key not in entries:
                self.refuse(node, f"a light has no '{key}'; add it")
        line = entries["stop_line_m"]
        place = self.on_route(
            line, "stop_line_m", self.number(line, "stop_line_m", 0.0, FARTHEST_M)
        )
        phases = []
        for entry in self.sequence(entries["phases"], "phases", "red: 8.0"):
            parts = self.mapping(entry, COLOURS, "a phase")
            if len(parts) != 1:
                self.refuse(
                    entry,
                    f"a phase is one colour and its seconds, such as 'red: 8.0'; the colours are {', '.join(COLOURS)}",
                )
            ((colour, seconds),) = parts.items()
            phases.append((colour, self.number(seconds, colour, 0.05, LONGEST_S)))
        if not phases:
            self.refuse(entries["phases"], "'phases' has no phase; add '- red: 8.0'")
        offset = (
            self.number(entries["offset_s"], "offset_s", -LONGEST_S, LONGEST_S)
            if "offset_s" in entries
            else 0.0
        )
        return TrafficLightPlan(*place, tuple(phases), offset)
