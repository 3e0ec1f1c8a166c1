"""Reads the obstacles of a scenario from a YAML file. The format stands in the README of this package."""
from __future__ import annotations

import difflib
import math
import os

import numpy as np
import yaml

from sdc_package.route import Route
from sdc_sim.obstacles import KINDS, Plan

FASTEST_MPS = 60.0
FARTHEST_M = 1e5
LARGEST_M = 50.0

_FRAMES = ("map", "route")
_KEYS = ("kind", "at", "yaw_rad", "path", "speed_mps", "start_s", "trigger_m", "size_m")


class ScenarioError(ValueError):
    """A scenario that no world should be made of; the message names the file, the line, the key and the mend."""


def load_obstacles(path: str, route: Route) -> list:
    """The Plans of a scenario file; none for an empty path. Raises ScenarioError.

    A point is [x, y] in the map with `frame: map`, and [metres along the route, metres to its left] with `frame: route`.
    """
    if not path:
        return []
    path = os.path.expanduser(path)
    try:
        with open(path, encoding="utf-8") as file:
            return _Reader(path, route).read(file.read())
    except RecursionError:
        raise ScenarioError(f"{path}: is nested too deep to be read; write one list of obstacles") from None
    except OSError as error:
        raise ScenarioError(f"{path}: {error.strerror}; set obstacles_path to a readable YAML file") from None
    except UnicodeDecodeError:
        raise ScenarioError(f"{path}: is no text; set obstacles_path to a YAML file") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place = f"{path}, line {mark.line + 1}" if mark else path
        problem = " ".join(str(getattr(error, "problem", None) or error).split())
        raise ScenarioError(f"{place}: is no YAML ({problem}); write 'key: value' and lists as '- '") from None


class _Reader:
    def __init__(self, path: str, route: Route):
        self.path = path
        self.route = route
        self.by_route = False

    def refuse(self, node, message: str):
        raise ScenarioError(f"{self.path}, line {node.start_mark.line + 1}: {message}")

    def read(self, text: str) -> list:
        root = yaml.compose(text, yaml.SafeLoader)
        if root is None:
            raise ScenarioError(f"{self.path}: is empty; write 'frame: map' and 'obstacles:'")
        entries = self.mapping(root, ("frame", "obstacles"), "the file")
        for key in ("frame", "obstacles"):
            if key not in entries:
                raise ScenarioError(f"{self.path}: key '{key}' is missing; add the line '{key}:'")
        self.by_route = self.word(entries["frame"], "frame", _FRAMES) == "route"
        if not isinstance(entries["obstacles"], yaml.SequenceNode):
            self.refuse(entries["obstacles"], "'obstacles' is no list; write each as '- kind: ...'")
        return [self.plan(node) for node in entries["obstacles"].value]

    def mapping(self, node, known, what: str) -> dict:
        if not isinstance(node, yaml.MappingNode):
            self.refuse(node, f"{what} is no mapping; write lines of 'key: value'")
        entries = {}
        for key_node, value_node in node.value:
            key = str(key_node.value)
            if key not in known:
                close = difflib.get_close_matches(key, known, n=1)
                mend = f"did you mean '{close[0]}'?" if close else f"the keys are {', '.join(known)}"
                self.refuse(key_node, f"unknown key '{key}'; {mend}")
            if key in entries:
                self.refuse(key_node, f"key '{key}' stands here twice; remove one of them")
            entries[key] = value_node
        return entries

    def word(self, node, key: str, known) -> str:
        word = str(node.value) if isinstance(node, yaml.ScalarNode) else "a list"
        if word not in known:
            close = difflib.get_close_matches(word, known, n=1)
            mend = f"did you mean '{close[0]}'?" if close else f"write one of {', '.join(known)}"
            self.refuse(node, f"'{key}' is {word!r}; {mend}")
        return word

    def number(self, node, key: str, low: float, high: float) -> float:
        try:
            if not isinstance(node, yaml.ScalarNode):
                raise ValueError("a list")
            value = float(node.value)
        except ValueError:
            found = repr(node.value) if isinstance(node, yaml.ScalarNode) else "a list"
            self.refuse(node, f"'{key}' is {found}; give a number")
        if not (math.isfinite(value) and low <= value <= high):
            self.refuse(node, f"'{key}' is {node.value}; give a number from {low:g} to {high:g}")
        return value

    def numbers(self, node, key: str, count: int, low: float, high: float) -> list:
        if not isinstance(node, yaml.SequenceNode) or len(node.value) != count:
            self.refuse(node, f"'{key}' must be a list of {count} numbers, such as [{', '.join(['1.0'] * count)}]")
        return [self.number(entry, key, low, high) for entry in node.value]

    def plan(self, node) -> Plan:
        entries = self.mapping(node, _KEYS, "an obstacle")
        if "kind" not in entries:
            self.refuse(node, f"an obstacle has no 'kind'; add 'kind: ' and one of {', '.join(KINDS)}")
        kind = self.word(entries["kind"], "kind", tuple(KINDS))
        if ("at" in entries) == ("path" in entries):
            self.refuse(node, "an obstacle needs either 'at: [x, y]' (it stands) or 'path: [[x, y], [x, y]]' (it moves)")
        size = tuple(KINDS[kind][:3])
        if "size_m" in entries:
            size = tuple(self.numbers(entries["size_m"], "size_m", 3, 0.05, LARGEST_M))
        moving = "path" in entries
        for key in ("speed_mps", "start_s", "trigger_m") if not moving else ("yaw_rad",):
            if key in entries:
                self.refuse(entries[key], f"'{key}' belongs to an obstacle with '{'at' if moving else 'path'}'; remove it")
        if moving:
            return self.moving(node, entries, kind, size)
        yaw = self.number(entries["yaw_rad"], "yaw_rad", -7.0, 7.0) if "yaw_rad" in entries else 0.0
        point, heading = self.place(entries["at"], "at")
        return Plan(kind, (point,), size, heading + yaw)

    def moving(self, node, entries: dict, kind: str, size: tuple) -> Plan:
        if "speed_mps" not in entries:
            self.refuse(node, "an obstacle with 'path' has no 'speed_mps'; add it in m/s")
        if "start_s" in entries and "trigger_m" in entries:
            self.refuse(entries["trigger_m"], "an obstacle has both 'start_s' and 'trigger_m'; remove one of them")
        path = entries["path"]
        if not isinstance(path, yaml.SequenceNode) or len(path.value) < 2:
            self.refuse(path, "'path' must be a list of two points or more, such as [[0, 0], [5, 0]]")
        points = tuple(self.place(entry, "path")[0] for entry in path.value)
        for entry, a, b in zip(path.value[1:], points, points[1:]):
            if math.hypot(b[0] - a[0], b[1] - a[1]) < 1e-3:
                self.refuse(entry, "'path' repeats the point before; remove one of them")
        return Plan(kind, points, size,
                    speed_mps=self.number(entries["speed_mps"], "speed_mps", 0.01, FASTEST_MPS),
                    start_s=self.number(entries["start_s"], "start_s", 0.0, 1e6) if "start_s" in entries else 0.0,
                    trigger_m=self.number(entries["trigger_m"], "trigger_m", 0.1, FARTHEST_M) if "trigger_m" in entries else None)

    def place(self, node, key: str):
        """A point in the map, and the heading that yaw_rad counts from."""
        first, second = self.numbers(node, key, 2, -FARTHEST_M, FARTHEST_M)
        if not self.by_route:
            return (first, second), 0.0
        if not 0.0 <= first <= self.route.length_m:
            self.refuse(node, f"'{key}' lies {first:g} m along a route of {self.route.length_m:.1f} m; give a place on it")
        x, y = (float(np.interp(first, self.route.s, self.route.points[:, axis])) for axis in (0, 1))
        heading = float(np.interp(first, self.route.s, self.route.heading))
        return (x - second * math.sin(heading), y + second * math.cos(heading)), heading
