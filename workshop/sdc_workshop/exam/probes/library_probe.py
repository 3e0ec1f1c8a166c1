#!/usr/bin/env python3
"""Evaluate expressions about a module of a library, for a check that asks.

Standard input is a socket. Each message is a pickled expression with its names; the answer is JSON,
see `described`. An exception ends the program.
"""

from __future__ import annotations

import copy
import dataclasses
import importlib
import io
import json
import os
import pickle
import re
import socket
import sys
import zlib
from functools import lru_cache
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import Any, Callable, Mapping

import numpy as np
import yaml

sys.path.append(str(Path(__file__).parent))

from road_picture import road  # noqa: E402

TICKS, STEP_NS = 15, 200_000_000
MAX_MESSAGE = 1 << 19  # bytes
_DECIMAL = re.compile(r"(?<![\w.])\d+\.\d+(?![\w.])")
_NUMPY = (
    *("abs", "allclose", "arcsin", "arctan", "arctan2", "array", "cos", "degrees", "diag", "eye"),
    *("flatnonzero", "hypot", "linalg", "linspace", "maximum", "minimum", "nan", "ones", "pi"),
    *("shape", "sin", "sqrt", "tan", "transpose", "unique", "where"),
)


def marked(mask: np.ndarray) -> int:
    """Return the number of marked pixels."""
    return int(np.count_nonzero(mask))


def part(value: object, *index: object) -> object:
    """Return an element of an array; the whole value where it has no such element."""
    try:
        return np.asarray(value)[tuple(index)]
    except IndexError:
        return value


def pid_outputs(gains: tuple, steps: list, **more: float) -> list:
    """Return the outputs of a PID controller after some steps."""
    from sdc_package.pid import Pid, PidGains

    controller = Pid(PidGains(*gains), -100.0, 100.0)
    return [controller.update(*step, **more)[0] for step in steps]


def symmetric(rows: list) -> np.ndarray:
    """Return a matrix plus its transpose."""
    return np.array(rows) + np.transpose(rows)


def tried(function: Callable, *arguments: float) -> object:
    """Return the result of a function, or "ZeroDivisionError" where it divides by zero."""
    try:
        return function(*arguments)
    except ZeroDivisionError:
        return "ZeroDivisionError"


def unchanged(function: Callable, *arguments: object) -> bool:
    """Return whether a function leaves the arrays and lists that it gets as they are."""
    given = copy.deepcopy(arguments)
    function(*given)
    return plain(given) == plain(arguments)


def digests(names: dict, wanted: list) -> list:
    """Return a number for the arrays that each of the values with these names is or has."""
    found = []
    for name in wanted:
        parts = getattr(names[name], "__dict__", {"": names[name]}).values()
        arrays = [part for part in parts if isinstance(part, (np.ndarray, list))]
        try:
            found.append(zlib.crc32(pickle.dumps(arrays)))
        except (AttributeError, TypeError, pickle.PicklingError):
            found.append(0)
    return found


def _quaternion(yaw: float, pitch: float, roll: float) -> SimpleNamespace:
    (cy, cp, cr), (sy, sp, sr) = (f(np.array([yaw, pitch, roll]) / 2) for f in (np.cos, np.sin))
    return SimpleNamespace(
        w=float(cr * cp * cy + sr * sp * sy),
        x=float(sr * cp * cy - cr * sp * sy),
        y=float(cr * sp * cy + sr * cp * sy),
        z=float(cr * cp * sy - sr * sp * cy),
    )


def yaw_of(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> float:
    """Return the yaw that the library reads from the quaternion of these angles."""
    from sdc_package.odometry import yaw_from_quaternion

    return yaw_from_quaternion(_quaternion(yaw, pitch, roll))


def speed_of(x: float, y: float) -> float:
    """Return the speed that the library reads from an odometry message with this velocity."""
    from nav_msgs.msg import Odometry

    from sdc_package.odometry import pose_and_speed

    message = Odometry()
    message.pose.pose.orientation.w = 1.0
    message.twist.twist.linear.x, message.twist.twist.linear.y = x, y
    return pose_and_speed(message)[3]


@lru_cache(maxsize=1)
def _parameters() -> dict:
    """Return the parameters of the solution's controller."""
    project = Path(__file__).resolve().parents[4]
    file = project / "catkin_ws/src/sdc_package/config/simple_controller.yaml"
    return dict(yaml.safe_load(file.read_text(encoding="utf-8")))


def path_with(planned: Callable[[int], float]) -> list:
    """Return the rows of the path y = x / 2 + 1, with the target speed of each point i [m/s]."""
    return [[0.9 * i, 0.45 * i + 1.0, planned(i)] for i in range(25)]


def controller_answer(
    x: float,
    y: float,
    yaw: float,
    speed: float,
    rows: list,
    parameters: dict | None = None,
    yaw_rate: float = 0.0,
    method: str = "stanley",
) -> list | None:
    """Return throttle, steer and brake of a car beside a path, after some ticks.

    The jerk limit allows so small a change of the acceleration that it takes these ticks. The car
    is at x, y [m] with a speed [m/s]; its heading becomes yaw [rad] with the yaw rate [rad/s]. See
    `path_with` for the rows. Without parameters of the controller, those of the solution count.
    """
    from sdc_common.driving import Observation
    from sdc_package.controller import Controller
    from sdc_package.local_path import ReferencePath
    from sdc_package.steering.axles import Axles
    from sdc_package.steering.loader import load_steering

    parameters = parameters or _parameters()
    steering = load_steering(method, parameters[method], Axles(**parameters["axles"]))
    controller = Controller(parameters.__getitem__, steering)
    path = ReferencePath()
    path.update(rows)
    for tick in range(TICKS):
        heading = yaw - yaw_rate * 1e-9 * STEP_NS * (TICKS - 1 - tick)
        observation = Observation(tick * STEP_NS, x, y, heading, speed)
        command = controller.command(observation, path)
    return None if command is None else [command.throttle, command.steer, command.brake]


_OWN = (
    *(controller_answer, digests, marked, part, path_with, pid_outputs, road, speed_of),
    *(symmetric, tried, unchanged, yaw_of),
)
HELPERS = {
    **{name: getattr(np, name) for name in _NUMPY},
    **{helper.__name__: helper for helper in _OWN},
}


def varied(expression: str, seed: str) -> str:
    """Return an expression with each decimal number changed by up to a tenth; integers stay."""
    random = Random(f"{seed}/{expression}")

    def changed(found: re.Match) -> str:
        return repr(float(f"{float(found[0]) * random.uniform(0.9, 1.1):.5g}"))

    return _DECIMAL.sub(changed, expression)


def evaluate(expression: str, names: dict) -> object:
    """Return the value of an expression."""
    return eval(compile(str(expression), "<check>", "eval"), names)


class Names(dict):
    """Names that expressions use; what is given is evaluated when it is used first."""

    given: dict = {}  # expressions by their name

    def __missing__(self, name: str) -> object:
        if name not in self.given:
            raise KeyError(name)
        self[name] = evaluate(self.given[name], self)
        return self[name]


def names_for(module: str, given: dict, asked: Mapping[str, Any]) -> Names:
    """Return the names that expressions about a module use; those in `asked` replace its own."""
    known = {**vars(importlib.import_module(module)), **HELPERS, **asked}
    names = Names((name, value) for name, value in known.items() if name not in given)
    names.given = given
    return names


def plain(value: object) -> object:
    """Return a value that JSON can hold; what it cannot hold as text."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(part) for part in value]
    return value if value is None or isinstance(value, (bool, int, float, str)) else str(value)


def described(value: Any, names: dict) -> object:
    """Return a value as JSON. Arrays and records are {"type", "is"} with their content.

    What else JSON cannot hold stays here: its content is a new name in `names`.
    """
    if isinstance(value, (list, tuple)) and not hasattr(value, "_asdict"):
        return [described(part, names) for part in value]
    if isinstance(value, np.ndarray):
        content: object = value.tolist()
    elif isinstance(value, dict) or hasattr(value, "_asdict") or dataclasses.is_dataclass(value):
        fields = value._asdict() if hasattr(value, "_asdict") else value
        fields = fields if isinstance(fields, dict) else vars(fields)
        content = {name: described(field, names) for name, field in fields.items()}
    else:
        content = plain(value)
        if content is None or not isinstance(content, str) or isinstance(value, str):
            return content
        content = f"_{len(names)}"
        names[content] = value
    return {"type": type(value).__name__, "is": content}


def main() -> None:
    """Answer until the socket is closed."""
    link = socket.socket(fileno=os.dup(0))
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    names: dict = {"plain": plain}

    def begin(module: str, given: dict) -> None:
        found = names_for(module, given, {})
        names.update({name: found[name] for name in given}, **found)

    names["begin"] = begin

    class Question(pickle.Unpickler):
        def persistent_load(self, name: str) -> object:
            return names[name]

    for message in iter(lambda: link.recv(MAX_MESSAGE), b""):
        expression, own = Question(io.BytesIO(message)).load()
        value = evaluate(expression, {**names, **own})
        link.send(json.dumps(described(value, names)).encode())


if __name__ == "__main__":
    main()
