"""Read path messages by the definition of their publisher.

A student's package defines its own Path and LocalPath. rospy refuses a definition with one field
more than that of sdc_msgs, so the world subscribes to them with rospy.AnyMsg.
"""

from __future__ import annotations

import functools
from operator import attrgetter
from typing import Any

import genpy
import genpy.dynamic
import rospy
from genmsg import InvalidMsgSpec, MsgGenerationException, MsgNotFound
from sdc_msgs.msg import LocalPath, Path

_KNOWN_CLASSES = {known._md5sum: known for known in (LocalPath, Path)}
_DEFINITION_ERRORS = (InvalidMsgSpec, KeyError, MsgGenerationException, MsgNotFound)


def waypoint_rows(path: Any, *fields: str) -> list[tuple[float, ...]]:
    """Return two or more named fields of each waypoint of a path, a rospy.AnyMsg or a message.

    Raises:
        ValueError: the definition of the publisher has no such fields, or the bytes do not fit it
    """
    if isinstance(path, rospy.AnyMsg):
        path = _decode(path)
    try:
        return list(map(attrgetter(*fields), path.waypoints))
    except AttributeError:
        raise ValueError(
            f"{path._type} needs a list 'waypoints' with the fields {', '.join(fields)}; "
            "add them to its .msg files"
        ) from None


def _decode(message: rospy.AnyMsg) -> genpy.Message:
    header = message._connection_header
    try:
        message_class = _KNOWN_CLASSES.get(header.get("md5sum")) or _message_class(
            header["type"], header["message_definition"]
        )
        return message_class().deserialize(message._buff)
    except (*_DEFINITION_ERRORS, genpy.MessageException) as error:
        raise ValueError(f"the publisher's definition cannot be read: {error}") from None


@functools.lru_cache(maxsize=None)
def _message_class(type_name: str, definition: str) -> type[genpy.Message]:
    return genpy.dynamic.generate_dynamic(type_name, definition)[type_name]
