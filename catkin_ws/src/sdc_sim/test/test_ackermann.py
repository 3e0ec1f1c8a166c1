"""The vehicle reaches the demanded speed and wheel angle within its limits."""

from __future__ import annotations

import math
import os

import pytest
import yaml

from sdc_sim.physics.ackermann import AckermannControl, AckermannGains, AckermannTarget
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.physics.vehicle_parameters import load_vehicle

HERE = os.path.dirname(os.path.abspath(__file__))
CONFIG = os.path.join(HERE, "..", "config")
with open(os.path.join(CONFIG, "sim.yaml"), encoding="utf-8") as file:
    GAINS = AckermannGains(**yaml.safe_load(file)["ackermann"])
PRESETS = ("tesla_model3", "ford_escort", "bmw_320i", "vw_vanagon", "snider2009")
TICK_S = 0.05


def drive(target, seconds, preset="tesla_model3", speed_mps=0.0, control=None, vehicle=None):
    parameters = load_vehicle(os.path.join(CONFIG, "vehicles", preset + ".yaml"))
    control = control or AckermannControl(parameters, GAINS)
    if vehicle is None:
        vehicle = Vehicle(parameters)
        vehicle.reset(0.0, 0.0, 0.0, speed_mps)
    states, commands = [], []
    for _ in range(round(seconds / TICK_S)):
        command = control.command(
            target, vehicle.state.speed_mps, vehicle.state.wheel_angle_rad, TICK_S
        )
        assert command.clamped() == (command, False)
        vehicle.step(command, TICK_S)
        states.append(vehicle.state)
        commands.append(command)
    return states, commands, vehicle


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize(
    ("start", "wanted"),
    [(0.0, 5.0), (0.0, 15.0), (12.0, 6.0), (8.0, 0.0), (0.0, -3.0), (5.0, -3.0), (-3.0, 4.0)],
)
def test_speed_is_reached_and_held(preset, start, wanted):
    states, _, _ = drive(AckermannTarget(speed_mps=wanted), 25.0, preset, start)
    assert states[-1].speed_mps == pytest.approx(wanted, abs=0.1)
    overshoot = max(
        math.copysign(1.0, wanted - start) * (state.speed_mps - wanted) for state in states
    )
    assert overshoot < 0.7


def test_target_of_zero_holds_the_vehicle():
    states, commands, _ = drive(AckermannTarget(), 10.0, speed_mps=4.0)
    assert [state.x_m for state in states[-20:]] == [states[-1].x_m] * 20
    assert commands[-1].brake == GAINS.hold_brake
    assert commands[-1].throttle == 0.0


def test_vehicle_starts_from_rest_as_if_it_had_not_driven_before():
    _, _, vehicle = drive(AckermannTarget(), 0.0)
    used = AckermannControl(vehicle.parameters, GAINS)
    drive(AckermannTarget(speed_mps=15.0), 20.0, control=used)
    drive(AckermannTarget(), 1.0, control=used)
    start = AckermannTarget(speed_mps=5.0)
    assert drive(start, 2.0, control=used)[1] == drive(start, 2.0)[1]


@pytest.mark.parametrize(("start", "wanted"), [(5.0, -3.0), (-3.0, 4.0)])
def test_change_of_direction_starts_with_the_brake(start, wanted):
    states, commands, _ = drive(AckermannTarget(speed_mps=wanted), 3.0, speed_mps=start)
    against = [
        command
        for state, command in zip(states, commands[1:])
        if state.speed_mps * start > GAINS.standstill_mps * abs(start)
    ]
    assert against
    assert all(command.throttle == 0.0 and command.brake > 0.0 for command in against)


@pytest.mark.parametrize(("angle", "sign"), [(0.2, 1.0), (-0.2, -1.0)])
def test_wheel_angle_is_reached_positive_to_the_left(angle, sign):
    states, commands, _ = drive(AckermannTarget(steering_angle_rad=angle, speed_mps=3.0), 5.0)
    assert states[-1].wheel_angle_rad == pytest.approx(angle, rel=0.01)
    assert states[-1].yaw_rad * sign > 0.5
    assert commands[-1].steer * sign < 0.0


def test_steering_rate_and_acceleration_and_jerk_are_kept():
    slow = AckermannTarget(
        steering_angle_rad=0.4,
        steering_rate_radps=0.1,
        speed_mps=10.0,
        acceleration_mps2=0.8,
        jerk_mps3=0.5,
    )
    states, _, _ = drive(slow, 12.0)
    angles = [state.wheel_angle_rad for state in states]
    assert max(b - a for a, b in zip(angles, angles[1:])) <= 0.1 * TICK_S * 1.3
    assert angles[19] == pytest.approx(0.1, abs=0.03)
    assert states[-1].wheel_angle_rad == pytest.approx(0.4, rel=0.02)
    speeds = [state.speed_mps for state in states]
    assert max(b - a for a, b in zip(speeds, speeds[10:])) < 0.8 * 10 * TICK_S * 1.25
    assert speeds[20] < 0.5 * 0.5 * 1.05**2 + 0.1, (
        "a jerk of 0.5 m/s^3 gives 0.25 m/s after one second"
    )


def control():
    return AckermannControl(
        load_vehicle(os.path.join(CONFIG, "vehicles", "tesla_model3.yaml")), GAINS
    )


@pytest.mark.parametrize(
    ("target", "within", "limited"),
    [
        (AckermannTarget(0.1, 0.2, 3.0, 0.4, 0.5), AckermannTarget(0.1, 0.2, 3.0, 0.4, 0.5), False),
        (AckermannTarget(speed_mps=1e9), AckermannTarget(speed_mps=60.0), True),
        (AckermannTarget(speed_mps=-1e9), AckermannTarget(speed_mps=-60.0), True),
        (
            AckermannTarget(steering_rate_radps=-1.0, acceleration_mps2=-1.0, jerk_mps3=-1.0),
            AckermannTarget(),
            True,
        ),
    ],
)
def test_targets_are_limited(target, within, limited):
    assert control().limited(target) == (within, limited)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(
    "name",
    ["steering_angle_rad", "steering_rate_radps", "speed_mps", "acceleration_mps2", "jerk_mps3"],
)
def test_nan_and_infinity_are_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        control().limited(AckermannTarget(**{name: value}))
