"""The controller answers an observation and a path with a command, without ROS."""

import math

import pytest

from sdc_common.configuration import node_config
from sdc_common.driving import Observation
from sdc_package.controller import Controller
from sdc_package.local_path import ReferencePath

PATH = ReferencePath()
PATH.update([(0.0, 0.0, 5.0), (10.0, 0.0, 5.0), (20.0, 0.0, 5.0)])


class Recorder:
    """A steering method that keeps the yaw rates and the places of its calls."""

    def __init__(self):
        self.yaw_rates = []
        self.places = []

    def wheel_angle(self, path, x, y, yaw, speed, yaw_rate):
        self.yaw_rates.append(yaw_rate)
        self.places.append((len(path.rows), x, y))
        return 0.1


@pytest.fixture
def controller():
    return Controller(node_config("sdc_package", "simple_controller").__getitem__, Recorder())


def at(seconds, yaw=0.0, speed=5.0):
    return Observation(round(seconds * 1e9), 1.0, 0.0, yaw, speed)


def test_command_carries_the_stamp_of_its_observation_and_numbers_of_a_message(controller):
    command = controller.command(at(1.0, speed=1.0), PATH)
    assert command.stamp_ns == 1_000_000_000
    assert (command.throttle > 0.0, command.brake, command.steer < 0.0) == (True, 0.0, True)
    assert command.steer != controller.steer
    assert command.steer == pytest.approx(controller.steer, abs=1e-7)


def test_acceleration_of_a_steering_method_replaces_that_of_the_speed_control(controller):
    controller.steering.acceleration_mps2 = -3.0
    brake = controller.command(at(1.0, speed=1.0), PATH).brake
    assert brake == pytest.approx(controller.pedal_map.pedals(-3.0)[1])
    controller.steering.acceleration_mps2 = None
    controller.command(at(1.05, speed=1.0), PATH)
    jerk = controller.speed_control.limits.jerk_mps3
    assert controller.speed_control.acceleration_mps2 == pytest.approx(-3.0 + jerk * 0.05)


def test_yaw_rate_is_measured_from_the_last_answered_observation(controller):
    controller.command(at(1.0, yaw=3.1), PATH)
    controller.command(at(1.1, yaw=-3.1), PATH)
    assert controller.steering.yaw_rates == [0.0, pytest.approx((2.0 * math.pi - 6.2) / 0.1)]


@pytest.mark.parametrize(
    ("seconds", "step_s"), [(1.05, 0.05), (1.2, 0.2), (9.0, 0.2), (1.0, 0.0), (0.5, 0.0)]
)
def test_time_step_is_not_negative_and_limited_after_a_gap(controller, seconds, step_s):
    controller.command(at(1.0), PATH)
    controller.command(at(seconds, yaw=0.01), PATH)
    rate = 0.01 / step_s if step_s else 0.0
    assert controller.steering.yaw_rates[1] == pytest.approx(rate)


def test_stop_brakes_along_the_last_path(controller):
    controller.command(at(1.0), PATH)
    command = controller.stop(at(1.5), PATH)
    brake = node_config("sdc_package", "simple_controller")["stop_brake"]
    assert (command.stamp_ns, command.throttle) == (0, 0.0)
    assert command.brake == pytest.approx(brake)
    assert controller.steering.places == [(3, 1.0, 0.0)] * 2


def test_controller_drives_on_after_a_stop_as_if_it_were_new(controller):
    fresh = controller.command(at(9.0, speed=4.0), PATH)
    for tick in range(40):
        controller.command(at(9.05 + 0.05 * tick, speed=1.0), PATH)
    controller.stop(at(11.5), PATH)
    controller.last_answered = None
    assert controller.command(at(9.0, speed=4.0), PATH) == fresh


def test_stop_holds_the_steering_without_a_path(controller):
    assert controller.stop(at(1.0), None).steer == 0.0
    steer = controller.command(at(1.5), PATH).steer
    assert controller.stop(at(2.0), None).steer == steer != 0.0
