"""The loop of the sim node without ROS: answers in lockstep, pictures and pauses."""

import os
from types import SimpleNamespace

import pytest
import rospy
from sdc_msgs.msg import CarlaVehicleControl

from sdc_common.testing.node_script import load_script
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.physics.vehicle_parameters import load_vehicle
from sdc_sim.ros.bridge_generations import GENERATIONS
from sdc_sim.ros.command_input import CommandInput
from sdc_sim.ros.request_queue import RequestQueue
from sdc_sim.ros.services import SimulationServices
from sdc_sim.ros.simulation_setup import Timeouts
from sdc_sim.ros.simulation_topics import SimulationTopics
from sdc_sim.ros.stack_processes import StackProcesses
from sdc_sim.simulation.pause import PauseControl
from sdc_sim.simulation.simulation import Simulation

PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
TESLA = os.path.join(PACKAGE, "config", "vehicles", "tesla_model3.yaml")
EGO = "/carla/ego_vehicle"
COMMANDS = EGO + "/vehicle_control_cmd"


class OfflineTopics(SimulationTopics):
    """Records what the sim publishes; the stack answers each observation at once.

    Attributes:
        published: the observations
        pictures: the observations that the camera takes
        running: what the bridge reports about the pause
        answers: returns the stamps of the commands after an observation
    """

    def __init__(self, simulation, receive, answers=lambda stamp: [stamp]):
        self.published, self.pictures, self.running = [], [], []
        self._simulation, self._receive, self.answers = simulation, receive, answers
        self._camera = SimpleNamespace(show=lambda shown, _again: self.pictures.append(shown))
        self.bridge = SimpleNamespace(
            publish_running=self.running.append, reset_lane_invasion=lambda: None
        )

    def publish(self):
        self.published.append(self._simulation.observation)
        for answer in self.answers(self._simulation.observation.stamp):
            command = CarlaVehicleControl(throttle=1.0)
            command.header.stamp = rospy.Time(*answer)
            command._connection_header = {"callerid": "/controller"}
            self._receive[COMMANDS](command)


class Node:
    """A Sim without ROS, with its callbacks by topic and its services by name."""

    def __init__(self, monkeypatch):
        self.receive, self.serve = {}, {}

        def subscribe(topic, message_class, callback, **options):
            self.receive[topic] = callback

        monkeypatch.setattr(rospy, "Subscriber", subscribe)
        monkeypatch.setattr(
            rospy, "Service", lambda name, kind, call: self.serve.update({name: call})
        )
        for name in ("loginfo_once", "logwarn_throttle"):
            monkeypatch.setattr(rospy, name, lambda *arguments: None)
        script = load_script(os.path.join(PACKAGE, "scripts", "sim.py"))
        sim = self.sim = script.Sim.__new__(script.Sim)
        sim.simulation = Simulation(Vehicle(load_vehicle(TESLA)), 0.05, 0.0)
        sim.lockstep, sim.timeouts, sim.pause = True, Timeouts(0.05, 0.05, 0.05), PauseControl()
        sim.requests = RequestQueue()
        stack = StackProcesses(lambda: ())
        sim.commands = CommandInput(
            EGO, CarlaVehicleControl, sim.simulation, sim.requests, stack, True, False
        )
        sim.topics = OfflineTopics(sim.simulation, self.receive)
        sim.handshake = SimpleNamespace(wait=lambda *arguments: None, answer_timeout_s=0.0)
        sim.starting, sim.start_deadline_s, sim.picture_due = False, 0.0, False
        sim.topics.start_clock = lambda: None
        setup = SimpleNamespace(
            simulation=sim.simulation,
            route=None,
            clicked_obstacle="car",
            bridge=GENERATIONS["0.9.3"],
            ego=EGO,
        )
        sim.requests.call = lambda function: function()
        SimulationServices(sim.requests, setup, sim.pause, sim.on_pause, sim.on_change)

    def run(self, monkeypatch, ticks):
        """Run the loop until so many observations are published."""
        monkeypatch.setattr(rospy, "is_shutdown", lambda: len(self.sim.topics.published) >= ticks)
        self.sim.loop()


@pytest.fixture
def node(monkeypatch):
    return Node(monkeypatch)


def stamps(ticks):
    return [(tick // 20, tick % 20 * 50_000_000) for tick in range(1, ticks + 1)]


def test_lockstep_takes_a_picture_of_every_observation(node, monkeypatch):
    node.run(monkeypatch, 40)
    assert [observation.stamp for observation in node.sim.topics.published] == stamps(40)
    assert node.sim.topics.published[-1].state.x_m > 1.0
    assert node.sim.topics.pictures == node.sim.topics.published


def test_real_time_takes_the_picture_of_the_last_observation_after_its_answer(node, monkeypatch):
    node.sim.lockstep = False
    node.run(monkeypatch, 10)
    assert node.sim.topics.pictures == node.sim.topics.published[:9]


def test_lockstep_waits_for_a_node_that_is_at_work_longer_than_for_others(node, monkeypatch):
    asked, answer = [], node.sim.topics.answers
    node.sim.topics.answers = lambda stamp: [] if stamp == (0, 200_000_000) else answer(stamp)

    def at_work(work_s):
        asked.append(work_s)
        if len(asked) == 3:
            OfflineTopics.publish(OfflineTopics(node.sim.simulation, node.receive))
        return True

    stack = SimpleNamespace(start_tick=lambda: None, found=True, at_work=at_work)
    node.sim.commands._stack = stack
    node.sim.timeouts = node.sim.timeouts._replace(start_s=60.0)
    given_up = []
    monkeypatch.setattr(node.sim.commands, "give_up", lambda: given_up.append(True))
    node.run(monkeypatch, 10)
    assert (len(asked), given_up) == (3, [])


@pytest.mark.parametrize("offset", [-2, -1, 1, 400])
def test_only_the_command_with_the_stamp_of_the_observation_answers_it(node, monkeypatch, offset):
    node.run(monkeypatch, 5)
    node.sim.requests.process_until(0.0)
    assert node.sim.commands.stamped and node.sim.is_answered()
    node.sim.topics.answers = lambda stamp: []
    node.sim.simulation.step()
    node.sim.publish()
    OfflineTopics.publish(
        OfflineTopics(node.sim.simulation, node.receive, lambda stamp: [stamps(500)[5 + offset]])
    )
    node.sim.requests.process_until(0.0)
    assert not node.sim.is_answered()
    OfflineTopics.publish(OfflineTopics(node.sim.simulation, node.receive))
    node.sim.requests.process_until(0.0)
    assert node.sim.is_answered()


def test_lockstep_waits_for_the_answer_and_does_not_step_for_other_commands(node, monkeypatch):
    node.run(monkeypatch, 3)
    given_up = []
    monkeypatch.setattr(node.sim.commands, "give_up", lambda: given_up.append(True))
    node.sim.wait_for_answer()
    assert given_up == [], "the last observation is answered"
    node.sim.topics.answers = lambda stamp: stamps(2)
    node.sim.simulation.step()
    node.sim.publish()
    monkeypatch.setattr(rospy, "is_shutdown", lambda: False)
    node.sim.wait_for_answer()
    assert given_up == [True], "only the timeout ends the wait"


def test_paused_sim_takes_no_step(node, monkeypatch):
    node.run(monkeypatch, 5)
    node.sim.pause.pause()
    checks = iter([False] * 3)
    monkeypatch.setattr(rospy, "is_shutdown", lambda: next(checks, True))
    node.sim.wait_for_answer()
    assert not node.sim.pause.take()
    assert node.sim.simulation.tick == 5
