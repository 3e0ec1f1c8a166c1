"""The messages between page and server.

From the page come JSON texts; `read_message` checks all that they contain. To the page go JSON
texts, and pictures as bytes: a header, then the JPEG or PNG file.
"""

from __future__ import annotations

import functools
import json
import struct
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from sdc_common.configuration import package_folder
from sdc_sim.yaml_document import check_parameter

MAX_MESSAGE_BYTES = 4096
MAX_PICTURE_NUMBER = 2**32 - 1
# Kind, number, stamp in simulated time [s], wall time at which this stamp was new [s].
_PICTURE_HEADER = struct.Struct("<BxxxIdd")
CAMERA, LANE_MASK, LANE_OVERLAY = 1, 2, 3


class Message(NamedTuple):
    """A message of a page."""

    kind: str  # a key of `messages` in config/page.yaml
    values: dict[str, Any] = {}  # the checked values of its fields


@functools.lru_cache(maxsize=None)
def page_schemas() -> dict[str, dict[str, dict]]:
    """Return config/page.yaml."""
    folder = Path(package_folder("sdc_cockpit"))
    return yaml.safe_load((folder / "config" / "page.yaml").read_text(encoding="utf-8"))


def check_fields(name: str, values: Any, fields: Mapping[str, dict], needed: Iterable[str]) -> None:
    """Check an object of a page by the JSON schemas of its fields; `name` is for the error.

    Raises:
        ValueError: a field is unknown, missing or wrong
    """
    schema = {"type": "object", "additionalProperties": False}
    check_parameter(name, values, {**schema, "properties": fields, "required": [*needed]})


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
    kind, messages = values.pop("type", None), page_schemas()["messages"]
    if not isinstance(kind, str) or kind not in messages:
        raise ValueError(f"unknown type {str(kind)[:40]!r}")
    check_fields(f"a message of type {kind!r}", values, messages[kind], messages[kind])
    return Message(kind, values)


def picture_message(kind: int, number: int, stamp_s: float, wall_s: float, file: bytes) -> bytes:
    """Return a picture for the page, which returns its number when it has drawn it.

    `wall_s` is the time at which the odometry of its stamp arrived, NaN if unknown.
    """
    return _PICTURE_HEADER.pack(kind, number & MAX_PICTURE_NUMBER, stamp_s, wall_s) + file


def json_message(kind: str, **values: Any) -> bytes:
    """Return a JSON text for the page, encoded."""
    return json.dumps(
        {"type": kind, **values}, separators=(",", ":"), allow_nan=False, ensure_ascii=False
    ).encode("utf-8", "replace")
