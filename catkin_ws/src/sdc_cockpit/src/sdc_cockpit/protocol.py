"""The messages between page and server.

From the page come JSON texts; `read_message` checks all that they contain. To the page go JSON
texts, and pictures as bytes: a header, then the JPEG or PNG file.
"""

from __future__ import annotations

import json
import struct
from typing import Any, Callable, NamedTuple

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
_WITHOUT_VALUES = ("drive", "release", "pause", "resume", "step", "reset", "reverse", "stop")
KEYS = (
    keyboard.THROTTLE_KEYS
    | keyboard.BRAKE_KEYS
    | keyboard.LEFT_KEYS
    | keyboard.RIGHT_KEYS
    | {keyboard.HAND_BRAKE_KEY}
)


class Message(NamedTuple):
    """A message of a page.

    Attributes:
        kind: a key of MESSAGES
        values: the checked values of its fields
    """

    kind: str
    values: dict[str, Any] = {}


def _number(low: float, high: float) -> Callable[[str, Any], float]:
    def check(name: str, value: Any) -> float:
        check_between(low, high, **{name: value})
        return float(value)

    return check


def _finite(name: str, value: Any) -> float:
    check_finite(**{name: value})
    return float(value)


def _picture(name: str, value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(f"{name} must be a whole number")
    check_between(0, MAX_PICTURE_NUMBER, **{name: value})
    return value


def _keys(name: str, value: Any) -> frozenset[str]:
    if not isinstance(value, list) or not all(isinstance(key, str) for key in value):
        raise ValueError(f"{name} must be a list of key names")
    unknown = set(value) - KEYS
    if unknown:
        raise ValueError(f"{name} has the unknown key {sorted(unknown)[0][:40]!r}")
    return frozenset(value)


def _of_type(wanted: type, noun: str) -> Callable[[str, Any], Any]:
    def check(name: str, value: Any) -> Any:
        if not isinstance(value, wanted):
            raise ValueError(f"{name} must be {noun}")
        return value

    return check


_SHARE = _number(0.0, 1.0)
_COORDINATE = _number(-_MAX_COORDINATE_M, _MAX_COORDINATE_M)
# Fields of each message, with a function that checks and returns the value.
MESSAGES: dict[str, dict[str, Callable[[str, Any], Any]]] = {
    **{name: {} for name in _WITHOUT_VALUES},
    # The held keys of the driver, or the pedals and the steer of a gamepad or a touch screen. The
    # page repeats them; their absence brakes the car.
    "keys": {"held": _keys},
    "pedals": {"throttle": _SHARE, "steer": _number(-1.0, 1.0), "brake": _SHARE},
    # A click on the road, in the map frame [m].
    "obstacle": {"x": _COORDINATE, "y": _COORDINATE},
    # The page has drawn this picture.
    "drawn": {"picture": _picture},
    # Whether the page shows the lane mask and the overlay of the lane.
    "show": {"mask": _of_type(bool, "true or false")},
    # A new value of a live parameter; the node refuses unknown names and bad values.
    "set": {"name": _of_type(str, "the name of a parameter"), "value": _finite},
    # A scenario and arguments of ./drive; `drive_arguments` checks them.
    "start": {"scenario": _of_type(str, "a name"), "arguments": _of_type(dict, "an object")},
}


def read_message(text: str | bytes) -> Message:
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
    kind = values.pop("type", None)
    if not isinstance(kind, str) or kind not in MESSAGES:
        raise ValueError(f"unknown type {str(kind)[:40]!r}")
    fields = MESSAGES[kind]
    for name in set(fields) - set(values):
        raise ValueError(f"a message of type {kind!r} needs {name}")
    for name in sorted(set(values) - set(fields)):
        raise ValueError(f"a message of type {kind!r} has no {name[:40]!r}")
    return Message(kind, {name: check(name, values[name]) for name, check in fields.items()})


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
