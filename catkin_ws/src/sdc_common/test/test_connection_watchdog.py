"""Clock that stops, and the registration with a restarted master."""

import types

import pytest
import rosgraph

from sdc_common.ros import connection_watchdog
from sdc_common.ros.connection_watchdog import ClockMonitor, MasterRegistration


def test_stop_and_continuation_of_the_clock_are_reported_once_each():
    clock = ClockMonitor(5.0, wall_s=100.0)
    changes = []
    for step in range(60):
        wall_s = 100.0 + 0.5 * step
        sim_time = 7.0 if step < 20 else 0.05 * step if step < 40 else 99.0
        if clock.update(wall_s, sim_time):
            changes.append((wall_s, clock.stopped))
    assert changes == [(105.0, True), (110.0, False), (125.0, True)]


def test_running_clock_reports_no_change():
    clock = ClockMonitor(5.0, wall_s=0.0)
    assert not any(clock.update(0.5 * step, step) for step in range(1000))


class RestartedMaster:
    """A ROS master, as rosgraph.Master gives access to it, and the XML-RPC interface of a node."""

    master_uri = "http://127.0.0.1:11311"
    pid = 100

    def __init__(self):
        self.nodes, self.parameters, self.updates = {"/car"}, {}, []
        self.publishers, self.subscribers, self.services = {}, {}, {}

    def restart(self):
        self.__init__()
        self.pid += 1
        self.nodes = set()

    def getPid(self):  # noqa: N802 (names of ROS)
        return self.pid

    def lookupNode(self, name):  # noqa: N802
        if name not in self.nodes:
            raise rosgraph.MasterException("unknown node")

    def hasParam(self, name):  # noqa: N802
        return name in self.parameters

    def setParam(self, name, value):  # noqa: N802
        self.parameters[name] = value

    def registerPublisher(self, topic, message_type, uri):  # noqa: N802
        self.nodes.add("/car")
        self.publishers[topic] = message_type, uri

    def registerSubscriber(self, topic, message_type, uri):  # noqa: N802
        self.nodes.add("/car")
        self.subscribers[topic] = message_type, uri
        return ["http://other:1"]

    def registerService(self, service, service_uri, uri):  # noqa: N802
        self.nodes.add("/car")
        self.services[service] = service_uri, uri

    def getPublications(self, caller):  # noqa: N802
        return 1, "", [["/odometry", "nav_msgs/Odometry"]]

    def getSubscriptions(self, caller):  # noqa: N802
        return 1, "", [["/cmd", "sdc_msgs/CarlaVehicleControl"]]

    def publisherUpdate(self, caller, topic, publishers):  # noqa: N802
        self.updates.append((topic, publishers))


@pytest.fixture
def master(monkeypatch):
    found = RestartedMaster()
    values = {"/use_sim_time": True, "/car": {"gain": 2.5}}
    services = [("/car/pause", "rosrpc://me:5")]
    manager = types.SimpleNamespace(get_services=lambda: services)
    for name, value in (
        ("rospy.get_name", lambda: "/car"),
        ("rospy.get_node_uri", lambda: "http://me:4"),
        ("rospy.get_param", lambda name, default: values.get(name, default)),
        ("rospy.logwarn", lambda *arguments: None),
        ("rosgraph.Master", lambda name: found),
        ("xmlrpc.client.ServerProxy", lambda uri: found),
        ("get_service_manager", lambda: manager),
    ):
        monkeypatch.setattr(f"{connection_watchdog.__name__}.{name}", value)
    return found


def test_node_registers_all_of_itself_with_a_restarted_master(master):
    registration = MasterRegistration()
    registration.check()
    assert (master.publishers, master.services) == ({}, {}), "the master knows the node"
    master.restart()
    registration.check()
    assert master.publishers == {"/odometry": ("nav_msgs/Odometry", "http://me:4")}
    assert master.subscribers == {"/cmd": ("sdc_msgs/CarlaVehicleControl", "http://me:4")}
    assert master.updates == [("/cmd", ["http://other:1"])]
    assert master.services == {"/car/pause": ("rosrpc://me:5", "http://me:4")}
    assert master.parameters == {"/use_sim_time": True, "/car": {"gain": 2.5}}


def test_restarted_master_keeps_the_parameters_that_it_has_already(master):
    registration = MasterRegistration()
    master.restart()
    master.parameters["/car"] = {"gain": 1.0}
    registration.check()
    assert master.parameters == {"/use_sim_time": True, "/car": {"gain": 1.0}}


def test_node_registers_the_rest_of_itself_with_a_master_that_knows_a_part(master):
    registration = MasterRegistration()
    master.restart()
    master.registerSubscriber("/new", "std_msgs/Empty", "http://me:4")  # rospy does that
    registration.check()
    assert "/odometry" in master.publishers


def test_node_registers_with_a_master_of_the_same_process_id(master):
    registration = MasterRegistration()
    master.restart()
    master.pid -= 1
    registration.check()
    assert "/odometry" in master.publishers
