"""Fixtures for tests with real processes under a ROS master, and the path of helper modules."""

import os
import sys

import pytest
import rospy
import yaml
from sdc_msgs.msg import SpeedReason

from sdc_common.processes import isolated_ros_environment
from sdc_common.ros import speed_reason_publisher
from sdc_testing import load_script
from sdc_testing.program import Program

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)


@pytest.fixture
def route():
    """Return a route that is driven in half a minute of simulated time."""
    return os.path.join(HERE, "routes", "fast_bends.csv")


@pytest.fixture
def bend(route, tmp_path):
    """Return a route along the first bend of that route, driven in ten seconds."""
    with open(route, encoding="utf-8") as file:
        rows = file.readlines()[40:125]
    path = tmp_path / "bend.csv"
    path.write_text("".join(rows))
    return path


class OfflineNode:
    """A node without ROS.

    Attributes:
        receive: its callbacks by topic
        published: the messages that it published
        call: its services by name
        config: its parameters
        instance: the object of its class
        reasons: stamp [ns] and name of what limited the speed, as it published them
    """

    def __init__(self, config):
        self.instance = None
        self.receive = {}
        self.published = []
        self.call = {}
        self.config = config
        self.reasons = []

    def serve(self, name, service_class, handler):
        """Take the place of rospy.Service."""
        self.call[name] = lambda: handler(None)

    def subscribe(self, topic, message_class, callback, **options):
        """Take the place of rospy.Subscriber."""
        self.receive[topic] = callback

    def advertise(self, topic, message_class, **options):
        """Take the place of LoopPublisher."""
        return self

    def publish(self, message):
        """Take the place of the publisher's method."""
        if isinstance(message, SpeedReason):
            self.reasons.append((message.header.stamp.to_nsec(), message.reason))
        else:
            self.published.append(message)


@pytest.fixture
def offline_node(monkeypatch):
    """Return a function that builds the node of a script, with the parameters of its config."""

    def refuse(message):
        raise ValueError(message)

    def build(name, class_name, **changes):
        script = load_script(os.path.join(HERE, "..", "scripts", name + ".py"))
        with open(os.path.join(HERE, "..", "config", name + ".yaml"), encoding="utf-8") as file:
            config = {**yaml.safe_load(file), **changes}
        node = OfflineNode(config)
        monkeypatch.setattr(
            rospy, "get_param", lambda key, *default: config.get(key.lstrip("~"), *default)
        )
        monkeypatch.setattr(rospy, "init_node", lambda name: None)
        monkeypatch.setattr(rospy, "logwarn_throttle", lambda seconds, text: None)
        monkeypatch.setattr(rospy, "loginfo", lambda text: None)
        monkeypatch.setattr(rospy, "Subscriber", node.subscribe)
        monkeypatch.setattr(rospy, "Service", node.serve)
        monkeypatch.setattr(script, "refuse", refuse)
        for module in (script, speed_reason_publisher):
            monkeypatch.setattr(module, "LoopPublisher", node.advertise)
        node.instance = getattr(script, class_name)()
        return node

    return build


@pytest.fixture
def environment(tmp_path):
    """Provide the environment of programs that belong to this test alone."""
    with isolated_ros_environment(tmp_path / "ros") as variables:
        yield variables


@pytest.fixture
def start(tmp_path):
    """Return a function that starts programs; end those that still run after the test."""
    programs = []

    def begin(command, environment, folder=tmp_path):
        programs.append(Program(command, environment, folder, tmp_path / f"log{len(programs)}"))
        return programs[-1]

    yield begin
    for program in programs:
        if program.process.poll() is None:
            program.interrupt()
