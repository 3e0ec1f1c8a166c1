"""The vehicle reaches the demanded speed and wheel angle within its limits."""

import math

import pytest
from presets import PRESETS, preset

from sdc_sim.physics.ackermann import AckermannControl, AckermannGains, AckermannTarget
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.yaml_document import packaged_config

GAINS = AckermannGains(**packaged_config("sim")["ackermann"])
TICK_S = 0.05


def drive(target, seconds, name="tesla_model3", speed_mps=0.0, control=None, vehicle=None):
    parameters = preset(name)
    control = control or AckermannControl(parameters, GAINS)
    if vehicle is None:
        vehicle = Vehicle(parameters)
        vehicle.reset(0.0, 0.0, 0.0, speed_mps)
    states, commands = [], []
    for _ in range(round(seconds / TICK_S)):
        state = vehicle.state
        command = control.command(target, state.speed_mps, state.wheel_angle_rad, TICK_S)
        assert command.clamped() == (command, False)
        vehicle.step(command, TICK_S)
        states.append(vehicle.state)
        commands.append(command)
    return states, commands, vehicle


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize(
    ("start", "wanted"),
    [(0.0, 5.0), (0.0, 15.0), (12.0, 6.0), (8.0, 0.0), (0.0, -3.0), (5.0, -3.0), (-3.0, 4.0)],
)
def test_speed_is_reached_and_held(name, start, wanted):
    states, _, _ = drive(AckermannTarget(speed_mps=wanted), 25.0, name, start)
    assert states[-1].speed_mps == pytest.approx(wanted, abs=0.1)
    sign = math.copysign(1.0, wanted - start)
    assert max(sign * (state.speed_mps - wanted) for state in states) < 0.7


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
    least = GAINS.standstill_mps * abs(start)
    pairs = zip(states, commands[1:])
    against = [command for state, command in pairs if state.speed_mps * start > least]
    assert against
    assert all(command.throttle == 0.0 and command.brake > 0.0 for command in against)


@pytest.mark.parametrize(("angle", "sign"), [(0.2, 1.0), (-0.2, -1.0)])
def test_wheel_angle_is_reached_positive_to_the_left(angle, sign):
    states, commands, _ = drive(AckermannTarget(steering_angle_rad=angle, speed_mps=3.0), 5.0)
    assert states[-1].wheel_angle_rad == pytest.approx(angle, rel=0.01)
    assert states[-1].yaw_rad * sign > 0.5
    assert commands[-1].steer * sign < 0.0


def test_steering_rate_and_acceleration_and_jerk_are_kept():
    states, _, _ = drive(AckermannTarget(0.4, 0.1, 10.0, 0.8, 0.5), 12.0)
    angles = [state.wheel_angle_rad for state in states]
    assert max(b - a for a, b in zip(angles, angles[1:])) <= 0.1 * TICK_S * 1.3
    assert angles[19] == pytest.approx(0.1, abs=0.03)
    assert states[-1].wheel_angle_rad == pytest.approx(0.4, rel=0.02)
    speeds = [state.speed_mps for state in states]
    assert max(b - a for a, b in zip(speeds, speeds[10:])) < 0.8 * 10 * TICK_S * 1.25
    # A jerk of 0.5 m/s^3 gives 0.25 m/s after one second.
    assert speeds[20] < 0.5 * 0.5 * 1.05**2 + 0.1


def control():
    return AckermannControl(preset(), GAINS)


@pytest.mark.parametrize(
    ("target", "within", "limited"),
    [
        (AckermannTarget(0.1, 0.2, 3.0, 0.4, 0.5), AckermannTarget(0.1, 0.2, 3.0, 0.4, 0.5), False),
        (AckermannTarget(speed_mps=1e9), AckermannTarget(speed_mps=60.0), True),
        (AckermannTarget(speed_mps=-1e9), AckermannTarget(speed_mps=-60.0), True),
        (AckermannTarget(0.0, -1.0, 0.0, -1.0, -1.0), AckermannTarget(), True),
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
