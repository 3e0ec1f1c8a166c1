"""Nodes of scripts without ROS: a test calls their callbacks and reads what they publish."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, NoReturn

import pytest
import rospy

from sdc_common.ros import node as ros_node
from sdc_common.ros import speed_reason_publisher
from sdc_testing import load_script


class OfflineNode:
    """What a node has connected.

    Attributes:
        receive: its callbacks by topic
        published: by topic, the messages that it published
        latched: the topics of its latched publishers
        call: the handlers of its services by name
        timers: the functions that it calls periodically
        config: its parameters; a change counts when it reads them again
        instance: the object of its class
    """

    def __init__(self, config: dict[str, Any]):
        self.receive: dict[str, Callable[[Any], None]] = {}
        self.published: dict[str, list] = defaultdict(list)
        self.latched: set[str] = set()
        self.call: dict[str, Callable[[Any], Any]] = {}
        self.timers: list[Callable[[], None]] = []
        self.config = config
        self.instance: Any = None

    def subscribe(
        self, topic: str, _: type, callback: Callable, callback_args: Any = None, **options: Any
    ) -> SimpleNamespace:
        """Take the place of rospy.Subscriber."""
        arguments = () if callback_args is None else (callback_args,)
        self.receive[topic] = lambda message: callback(message, *arguments)
        return SimpleNamespace(unregister=lambda: self.receive.pop(topic, None))

    def serve(self, name: str, _: type, handler: Callable) -> None:
        """Take the place of rospy.Service."""
        self.call[name] = handler

    def advertise(self, topic: str, _: type, latch: bool = False, **options: Any) -> Publisher:
        """Take the place of rospy.Publisher."""
        self.latched |= {topic} if latch else set()
        return Publisher(self.published[topic])


class Publisher:
    """A publisher with a subscriber."""

    def __init__(self, messages: list):
        self._messages = messages

    def get_num_connections(self) -> int:
        """Return the number of subscribers."""
        return 1

    def publish(self, message: Any, *_: Any) -> None:
        """Keep a message."""
        self._messages.append(message)


def offline_node(
    monkeypatch: pytest.MonkeyPatch, path: str, class_name: str, config: dict[str, Any]
) -> OfflineNode:
    """Return the node of a script with these parameters; what it refuses raises ValueError."""
    node, script = OfflineNode(config), load_script(path)

    def refuse(message: object) -> NoReturn:
        raise ValueError(message)

    def get_param(name: str, *default: Any) -> Any:
        key = name.lstrip("~")
        return config.get(key, *default) if default else config[key]

    for attribute, value in (
        ("get_param", get_param),
        ("set_param", lambda name, value: config.update({name.lstrip("~"): value})),
        ("init_node", lambda name: None),
        ("logwarn_throttle", lambda seconds, text: None),
        ("loginfo", lambda text, *values: None),
        ("spin", lambda: None),
        ("Publisher", node.advertise),
        ("Subscriber", node.subscribe),
        ("Service", node.serve),
    ):
        monkeypatch.setattr(rospy, attribute, value)
    for attribute, value in (
        ("refuse", refuse),
        ("LoopPublisher", node.advertise),
        ("watch_connections", lambda: None),
        ("every", lambda seconds, function: node.timers.append(function)),
    ):
        monkeypatch.setattr(script, attribute, value, raising=False)
    monkeypatch.setattr(ros_node, "refuse", refuse)
    monkeypatch.setattr(speed_reason_publisher, "LoopPublisher", node.advertise)
    node.instance = getattr(script, class_name)()
    return node
