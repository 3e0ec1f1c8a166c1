"""The steering method mpc: its limits, and the motion and delay that it estimates."""

import math
import sys

import numpy as np
import pytest

from sdc_common.configuration import node_config
from sdc_common.driving import Command
from sdc_mpc.motion_estimator import MotionFilter, TickModel, Y
from sdc_package.actuation import PedalMap, SteeringMap
from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles
from sdc_package.steering.loader import load_steering
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.physics.vehicle_parameters import load_vehicle
from sdc_sim.yaml_document import config_path

CONFIG = node_config("sdc_package", "simple_controller")
AXLES = Axles(**CONFIG["axles"])
TICK_S = CONFIG["mpc"]["tick_s"]
needs_osqp = pytest.mark.usefixtures("osqp")


@pytest.fixture
def osqp():
    return pytest.importorskip("osqp", reason="osqp is not installed (docker/prepare mpc)")


def build(**changes):
    return load_steering("mpc", {**CONFIG["mpc"], **changes}, AXLES)


def circle(curvature, speed_mps):
    """Return a path along an arc that begins 10 m behind the origin."""
    s = np.arange(-10.0, 400.0)
    x, y = (np.sin(curvature * s), 1.0 - np.cos(curvature * s)) if curvature else (s, 0.0 * s)
    path = ReferencePath()
    scale = curvature or 1.0
    path.update([(px, py, speed_mps) for px, py in zip(x / scale, y / scale)])
    return path


def follow(path, speed_mps, delay, ticks, noise_m=0.0, friction=1.0, **changes):
    """Drive the simulated car; return the method, true errors and wheel angles."""
    method, steering_map = build(**changes), SteeringMap(**CONFIG["steering"])
    pedal_map = PedalMap(**CONFIG["pedals"])
    car = Vehicle(load_vehicle(config_path("vehicles/tesla_model3.yaml")), friction)
    car.reset(0.0, 0.0, 0.0, speed_mps)
    random, yaw, errors, wheels = np.random.default_rng(1), 0.0, [], []
    commands = [Command()] * delay
    for _ in range(ticks):
        state = car.state
        x, y = np.array([state.x_m, state.y_m]) + noise_m * random.normal(size=2)
        speed = math.hypot(state.speed_mps, state.lateral_speed_mps)
        rate, yaw = (state.yaw_rad - yaw) / TICK_S, state.yaw_rad
        wheels.append(method.wheel_angle(path, x, y, yaw, speed, rate))
        steer, _ = steering_map.command(wheels[-1], speed)
        throttle, brake = pedal_map.pedals(method.acceleration_mps2)
        commands.append(Command(throttle, steer, brake))
        car.step(commands.pop(0), TICK_S)
        errors.append(path.line.nearest(car.state.x_m, car.state.y_m).cross_track_m)
    return method, np.array(errors), np.array(wheels)


@pytest.mark.parametrize("speed", [3.0, 12.25, 25.0])
def test_tick_model_equals_small_steps_of_the_bicycle(speed):
    front = AXLES.rear_m / AXLES.wheelbase_m / AXLES.front_compliance
    rear = AXLES.front_m / AXLES.wheelbase_m / AXLES.rear_compliance
    inertia, wheel, steps = CONFIG["mpc"]["gyration_m"] ** 2, 0.03, 2000
    e, theta, v, r = start = 0.2, -0.05, 0.1, 0.15
    for _ in range(steps):
        slip_front = wheel - (v + AXLES.front_m * r) / speed
        slip_rear = -(v - AXLES.rear_m * r) / speed
        force_front, force_rear = front * slip_front, rear * slip_rear
        turning = (AXLES.front_m * force_front - AXLES.rear_m * force_rear) / inertia
        change = speed * theta + v, r, force_front + force_rear - speed * r, turning
        e, theta, v, r = np.array([e, theta, v, r]) + TICK_S / steps * np.array(change)
    held = TickModel(AXLES, CONFIG["mpc"]["gyration_m"], TICK_S).at(speed)
    assert held @ (*start, wheel) == pytest.approx([e, theta, v, r], abs=2e-3)


def test_filter_trusts_positions_without_noise():
    model = TickModel(AXLES, CONFIG["mpc"]["gyration_m"], TICK_S)
    motion_filter = MotionFilter(model, TICK_S, (0.05, 0.001, 0.05))
    car, errors = np.zeros(4), []
    motion_filter.start((0.0, 0.0, 0.0), 10.0, (0.0, 0.0))
    for tick in range(1, 301):  # wind comes up after 250 ticks
        car = model.at(10.0) @ (*car, 0.005 if tick > 250 else 0.0)
        motion_filter.update((0.0, 0.0), (10.0 * TICK_S * tick, car[0], car[1]), 10.0)
        errors.append(abs(motion_filter.state[Y] - car[0]))
    assert max(errors) < 0.0012  # with the greatest noise it is 0.0017


@pytest.mark.slow(1)
@needs_osqp
@pytest.mark.parametrize("curvature", [1 / 150.0, -1 / 150.0])
def test_car_on_a_circle_keeps_no_error(curvature):
    _, errors, _ = follow(circle(curvature, 18.0), 18.0, 0, 300)
    assert np.abs(errors[-100:]).max() < 0.01


@pytest.mark.slow(2)
@needs_osqp
@pytest.mark.parametrize("delay", [0, 2, 4])
@pytest.mark.parametrize("assumed_s", [0.0, 0.2])
def test_delay_of_the_commands_is_found_and_compensated(delay, assumed_s):
    method, errors, _ = follow(circle(1 / 150.0, 18.0), 18.0, delay, 300, delay_s=assumed_s)
    assert method.estimator.delay == delay
    assert np.abs(errors[-100:]).max() < 0.02


@pytest.mark.slow(1)
@needs_osqp
def test_noise_of_the_position_is_filtered():
    _, errors, wheels = follow(circle(1 / 150.0, 18.0), 18.0, 2, 400, 0.05, 0.6, delay_s=0.1)
    assert math.sqrt(np.mean(errors[100:] ** 2)) < 0.025
    assert np.abs(np.diff(wheels[100:])).max() < 0.01


@needs_osqp
def test_limits_hold_far_from_the_path():
    method, path = build(), circle(0.0, 20.0)
    last_wheel = last_acceleration = 0.0
    for speed in [10.0, 10.0, 10.1, 10.1, 10.2, 10.3, 10.4, 10.6]:
        wheel = math.tan(method.wheel_angle(path, 0.0, 4.0, 0.3, speed, 0.0))
        acceleration = method.acceleration_mps2
        turn = 2.0 * CONFIG["steering"]["max_wheel_angle_rad"] / CONFIG["mpc"]["steer_travel_s"]
        assert abs(wheel - last_wheel) < turn * TICK_S + 2e-3
        change = CONFIG["mpc"]["jerk_mps3"] * TICK_S
        assert last_acceleration < acceleration < last_acceleration + change + 1e-3
        last_wheel, last_acceleration = wheel, acceleration
    assert wheel < -0.1


@needs_osqp
def test_speed_control_drives_slowly_and_before_a_stop():
    method = build()
    method.wheel_angle(circle(0.0, 10.0), 0.0, 0.0, 0.0, 2.0)
    assert method.acceleration_mps2 is None
    method.wheel_angle(circle(0.0, 10.0), 0.1, 0.0, 0.0, 9.0)
    assert method.acceleration_mps2 is not None
    stop = ReferencePath()
    stop.update([(-5.0, 0.0, 9.0), (0.0, 0.0, 9.0), (6.0, 0.0, 0.0), (9.0, 0.0, 0.0)])
    method.wheel_angle(stop, 0.5, 0.0, 0.0, 9.0)
    assert method.acceleration_mps2 is None


def test_missing_solver_is_named_with_the_fix(monkeypatch):
    monkeypatch.setitem(sys.modules, "osqp", None)
    with pytest.raises(ValueError, match="^section 'mpc': osqp is not installed; run docker/prep"):
        build()
