"""The messages between page and server.

From the page come JSON texts; `read_message` checks all that they contain. To the page go JSON
texts, and pictures as bytes: a header, then the JPEG or PNG file.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field
from typing import Any, Callable, Mapping, Union

from sdc_common.validation import check_between, check_finite
from sdc_sim.manual_control import keyboard

MAX_MESSAGE_BYTES = 4096
MAX_PICTURE_NUMBER = 2**32 - 1
# Coordinates of a click beyond this are an error [m].
_MAX_COORDINATE_M = 1e5
# Kind, number, stamp in simulated time [s], wall time at which this stamp was new [s].
_PICTURE_HEADER = struct.Struct("<BxxxIdd")
PICTURE_HEADER_BYTES = _PICTURE_HEADER.size
CAMERA, LANE_MASK, LANE_OVERLAY = 1, 2, 3
KEYS = (
    keyboard.THROTTLE_KEYS
    | keyboard.BRAKE_KEYS
    | keyboard.LEFT_KEYS
    | keyboard.RIGHT_KEYS
    | {keyboard.HAND_BRAKE_KEY}
)


@dataclass(frozen=True)
class Simple:
    """A message without values, one of SIMPLE."""

    name: str


@dataclass(frozen=True)
class Keys:
    """The held keys of the driver. The page repeats it; its absence brakes the car."""

    held: frozenset[str]


@dataclass(frozen=True)
class Pedals:
    """Pedals and steer of a gamepad or a touch screen; repeated as Keys."""

    throttle: float
    steer: float
    brake: float


@dataclass(frozen=True)
class ObstacleClick:
    """A click on the road, in the map frame [m]."""

    x_m: float
    y_m: float


@dataclass(frozen=True)
class Drawn:
    """The page has drawn a picture."""

    picture: int


@dataclass(frozen=True)
class ShowMask:
    """Whether the page shows the lane mask and the overlay of the lane."""

    mask: bool = field(default=False)


@dataclass(frozen=True)
class SetParameter:
    """A new value of a live parameter; the node refuses unknown names and bad values."""

    name: str
    value: float


@dataclass(frozen=True)
class StartDrive:
    """A scenario and arguments of ./drive; `drive_arguments` checks them."""

    scenario: str
    arguments: Mapping[str, Any]


ClientMessage = Union[
    Simple, Keys, Pedals, ObstacleClick, Drawn, ShowMask, SetParameter, StartDrive
]
SIMPLE = ("drive", "release", "pause", "resume", "step", "reset", "reverse", "stop")


def read_message(text: str | bytes) -> ClientMessage:
    """Return the message of a page.

    Raises:
        ValueError: it is no message of this protocol; the text names what is wrong
    """
    if isinstance(text, bytes):
        raise ValueError("a page sends text, not bytes")
    if len(text) > MAX_MESSAGE_BYTES:
        raise ValueError(f"a message has at most {MAX_MESSAGE_BYTES} characters, got {len(text)}")
    try:
        values = json.loads(text)
    except RecursionError:
        raise ValueError("the JSON is nested too deeply") from None
    if not isinstance(values, dict):
        raise ValueError("a message is a JSON object")
    name = values.pop("type", None)
    if not isinstance(name, str) or (name not in SIMPLE and name not in _READERS):
        raise ValueError(f"unknown type {str(name)[:40]!r}")
    if name in SIMPLE:
        message: ClientMessage = Simple(name)
        wanted: set = set()
    else:
        read, wanted = _READERS[name]
        missing = wanted - set(values)
        if missing:
            raise ValueError(f"a message of type {name!r} needs {', '.join(sorted(missing))}")
        message = read(values)
    unknown = set(values) - wanted
    if unknown:
        raise ValueError(f"a message of type {name!r} has no {sorted(unknown)[0][:40]!r}")
    return message


def _keys(values: Mapping[str, Any]) -> Keys:
    held = values["held"]
    if not isinstance(held, list) or not all(isinstance(key, str) for key in held):
        raise ValueError("held must be a list of key names")
    unknown = set(held) - KEYS
    if unknown:
        raise ValueError(f"held has the unknown key {sorted(unknown)[0][:40]!r}")
    return Keys(frozenset(held))


def _pedals(values: Mapping[str, Any]) -> Pedals:
    check_between(0.0, 1.0, throttle=values["throttle"], brake=values["brake"])
    check_between(-1.0, 1.0, steer=values["steer"])
    return Pedals(float(values["throttle"]), float(values["steer"]), float(values["brake"]))


def _obstacle(values: Mapping[str, Any]) -> ObstacleClick:
    check_finite(x=values["x"], y=values["y"])
    check_between(-_MAX_COORDINATE_M, _MAX_COORDINATE_M, x=values["x"], y=values["y"])
    return ObstacleClick(float(values["x"]), float(values["y"]))


def _drawn(values: Mapping[str, Any]) -> Drawn:
    number = values["picture"]
    if isinstance(number, bool) or not isinstance(number, int):
        raise ValueError("picture must be a whole number")
    check_between(0, MAX_PICTURE_NUMBER, picture=number)
    return Drawn(number)


def _show(values: Mapping[str, Any]) -> ShowMask:
    if not isinstance(values["mask"], bool):
        raise ValueError("mask must be true or false")
    return ShowMask(values["mask"])


def _set(values: Mapping[str, Any]) -> SetParameter:
    if not isinstance(values["name"], str):
        raise ValueError("name must be the name of a parameter")
    check_finite(value=values["value"])
    return SetParameter(values["name"], float(values["value"]))


def _start(values: Mapping[str, Any]) -> StartDrive:
    if not isinstance(values["scenario"], str):
        raise ValueError("scenario must be a name")
    if not isinstance(values["arguments"], dict):
        raise ValueError("arguments must be an object")
    return StartDrive(values["scenario"], values["arguments"])


_READERS: dict[str, tuple[Callable[[Mapping[str, Any]], ClientMessage], set]] = {
    "keys": (_keys, {"held"}),
    "pedals": (_pedals, {"throttle", "steer", "brake"}),
    "obstacle": (_obstacle, {"x", "y"}),
    "drawn": (_drawn, {"picture"}),
    "show": (_show, {"mask"}),
    "set": (_set, {"name", "value"}),
    "start": (_start, {"scenario", "arguments"}),
}


def picture_message(kind: int, number: int, stamp_s: float, wall_s: float, file: bytes) -> bytes:
    """Return a picture for the page.

    Args:
        kind: CAMERA, LANE_MASK or LANE_OVERLAY
        number: number of the picture, which the page returns when it has drawn it
        stamp_s: its stamp [s]
        wall_s: wall time at which the odometry of this stamp arrived [s]; NaN if unknown
        file: content of the JPEG or PNG file
    """
    return _PICTURE_HEADER.pack(kind, number & MAX_PICTURE_NUMBER, stamp_s, wall_s) + file


def read_picture(message: bytes) -> tuple[int, int, float, float, bytes]:
    """Return the arguments of `picture_message`."""
    kind, number, stamp_s, wall_s = _PICTURE_HEADER.unpack_from(message)
    return kind, number, stamp_s, wall_s, message[PICTURE_HEADER_BYTES:]


def json_message(kind: str, **values: Any) -> bytes:
    """Return a JSON text for the page, encoded."""
    return json.dumps(
        {"type": kind, **values}, separators=(",", ":"), allow_nan=False, ensure_ascii=False
    ).encode("utf-8", "replace")
