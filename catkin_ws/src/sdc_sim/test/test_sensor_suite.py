"""Readings agree with the motion within their errors, and errors have their size and their seed."""

import math
import re
from dataclasses import astuple

import numpy as np
import pytest
from presets import TESLA

from sdc_common.driving import Command
from sdc_common.geometry.route import Route
from sdc_sim.physics.vehicle import Vehicle, VehicleState
from sdc_sim.scenario.configuration import checked
from sdc_sim.sensors.errors import ErrorSizes, OdometryNoise, SensorErrors
from sdc_sim.sensors.model import Moment, SensorContext, sensor_settings
from sdc_sim.sensors.motion_sensors import WHEEL_RADIUS_M, Gnss, wheel_speeds_radps
from sdc_sim.sensors.suite import SensorSuite
from sdc_sim.simulation.simulation import Simulation

pytestmark = pytest.mark.slow(1)

TICK_S = 0.05
TRUE = VehicleState(10.0, -5.0, 0.3, 8.0)
ACCELERATION_NOISE, RATE_NOISE, GNSS_NOISE = 0.1, 0.005, 1.0


def simulation_with(seed=3, route=None, latency_s=0.0, **sensors):
    settings = {name: sensor_settings(name, values) for name, values in sensors.items()}
    suite = SensorSuite(settings, TESLA, TICK_S, seed, route)
    return Simulation(Vehicle(TESLA), TICK_S, 0.0, sensors=suite, sensor_latency_s=latency_s)


def weave(simulation, ticks):
    """Drive with smooth commands of all kinds; return the observations."""
    observations = []
    for tick in range(ticks):
        t = tick * TICK_S
        pedal = 0.3 + 0.4 * math.sin(0.5 * t)
        command = Command(max(0.0, pedal), 0.05 * math.sin(0.7 * t), max(0.0, -pedal))
        simulation.step(command)
        observations.append(simulation.snapshot)
    return observations


def each(observations, field):
    readings = (getattr(observation.readings, field) for observation in observations)
    return [one for one in readings if one is not None]


@pytest.fixture(scope="module")
def drive():
    """A drive of a minute with an inertial unit and GNSS in each tick."""
    imu = {"acceleration_noise_mps2": ACCELERATION_NOISE, "rate_noise_radps": RATE_NOISE}
    gnss = {"period_s": TICK_S, "noise_m": GNSS_NOISE}
    return weave(simulation_with(imu={"period_s": TICK_S, **imu}, gnss=gnss), 1200)


def assert_white(residuals, sigma):
    """The residuals have mean 0 and this standard deviation, and each tick has its own.

    The limits are those that one of 10,000 correct sensors exceeds (3.9 standard deviations).
    """
    count = len(residuals)
    scaled = residuals / sigma
    assert abs(scaled.mean()) < 3.9 / math.sqrt(count)
    assert abs((scaled**2).mean() - 1.0) < 3.9 * math.sqrt(2.0 / count)
    assert abs((scaled[1:] * scaled[:-1]).mean()) < 3.9 / math.sqrt(count)


def trajectory(drive):
    states = [observation.state for observation in drive]
    return (np.array([getattr(state, name) for state in states]) for name in ("x_m", "y_m"))


def test_inertial_unit_agrees_with_the_derivatives_of_the_trajectory(drive):
    x, y = trajectory(drive)
    yaw = np.array([observation.state.yaw_rad for observation in drive])[1:-1]
    east, north = (np.diff(values, 2) / TICK_S**2 for values in (x, y))
    c, s = np.cos(yaw), np.sin(yaw)
    readings = [observation.readings.imu for observation in drive][1:-1]
    measured = np.array([reading.acceleration_mps2 for reading in readings])
    assert (np.abs(measured[:, :2]).max(axis=0) > 1.5).all()
    # A command acts from its tick on: the reading is that before the step, the derivative the mean
    # of both sides. Here this is up to 0.035 m/s^2, which the noise covers.
    assert_white(measured[:, 0] - (c * east + s * north), ACCELERATION_NOISE)
    assert_white(measured[:, 1] - (c * north - s * east), ACCELERATION_NOISE)
    assert_white(measured[:, 2] - 9.81, ACCELERATION_NOISE)

    all_yaw = np.array([observation.state.yaw_rad for observation in drive])
    turning = (all_yaw[2:] - all_yaw[:-2]) / (2.0 * TICK_S)
    rates = np.array([reading.rate_radps for reading in readings])
    assert np.abs(turning).max() > 0.2
    assert_white(rates[:, 2] - turning, RATE_NOISE)
    assert_white(rates[:, 0], RATE_NOISE)


def test_gnss_agrees_with_the_trajectory(drive):
    x, y = trajectory(drive)
    fixes = np.array([observation.readings.gnss[:2] for observation in drive])
    assert_white(fixes[:, 0] - x, GNSS_NOISE)
    assert_white(fixes[:, 1] - y, GNSS_NOISE)


def test_wheels_roll_about_one_centre():
    # On a circle each wheel covers its own radius; the front wheels follow the mean angle.
    yaw_rate, speed = 0.4, 5.0
    slip = 0.4 * TESLA.rear_axle_m  # the rear axle does not slide
    angle = math.atan2(slip + TESLA.front_axle_m * yaw_rate, speed)
    motion = {"speed_mps": speed, "lateral_speed_mps": slip, "yaw_rate_radps": yaw_rate}
    state = VehicleState(**motion, wheel_angle_rad=angle)
    front_left, front_right, left, right = wheel_speeds_radps(state, TESLA)
    radius = speed / yaw_rate
    half_track = 0.4 * TESLA.width_m
    assert left * WHEEL_RADIUS_M == pytest.approx(yaw_rate * (radius - half_track))
    assert right * WHEEL_RADIUS_M == pytest.approx(yaw_rate * (radius + half_track))
    middle = math.hypot(radius, TESLA.front_axle_m + TESLA.rear_axle_m)
    assert 0.5 * (front_left + front_right) * WHEEL_RADIUS_M == pytest.approx(yaw_rate * middle)
    assert wheel_speeds_radps(VehicleState(speed_mps=-3.5), TESLA) == pytest.approx([-10.0] * 4)


def test_bias_walk_and_scale_have_their_sizes():
    sizes = ErrorSizes(bias=0.3, walk=0.2, scale=0.01)
    errors = SensorErrors(7, 1, [sizes] * 1000, 0.1)
    start = np.array(errors.bias)
    scales = np.array(errors.apply([100.0] * 1000, 0)) - errors.bias
    for tick in range(1, 40):
        errors.apply([0.0] * 1000, tick)
    assert start.std() == pytest.approx(0.3, rel=0.1)
    assert (np.array(errors.bias) - start).std() == pytest.approx(0.2 * math.sqrt(4.0), rel=0.1)
    assert scales.std() == pytest.approx(1.0, rel=0.1)
    assert scales.mean() == pytest.approx(100.0, abs=0.13)


def test_seed_decides_the_errors_and_sensors_do_not_change_those_of_others():
    gnss = {"period_s": 0.2, "noise_m": 1.0, "bias_m": 0.5, "walk_m": 0.1}
    alone = each(weave(simulation_with(gnss=gnss), 60), "gnss")
    wheels = {"period_s": 0.05, "noise_radps": 0.3}
    assert each(weave(simulation_with(gnss=gnss, wheel_speeds=wheels), 60), "gnss") == alone
    assert each(weave(simulation_with(seed=4, gnss=gnss), 60), "gnss") != alone
    assert len(alone) == 15


def test_late_reading_shows_the_state_of_that_many_ticks_ago():
    simulation = simulation_with(
        speedometer={"period_s": TICK_S, "latency_s": 0.15}, wheel_speeds={"period_s": TICK_S}
    )
    assert simulation.snapshot.readings.speed_mps == 0.0
    observations = weave(simulation, 40)
    speeds = [observation.state.speed_mps for observation in observations]
    assert each(observations, "speed_mps")[3:] == speeds[:-3]
    rear_left = each(observations, "wheel_speeds_radps")[-1][2]
    assert rear_left == pytest.approx(speeds[-1] / WHEEL_RADIUS_M, rel=0.05)


def test_reset_repeats_the_readings():
    imu = {"period_s": 0.05, "latency_s": 0.1, "acceleration_noise_mps2": 0.1, "rate_walk_radps": 1}
    gnss = {"period_s": 0.1, "noise_m": 1.0, "walk_m": 0.3}
    gnss["multipath"] = [{"from_s": 0.0, "to_s": 9.0, "offset_m": 3.0}]
    wheels = {"period_s": 0.05, "noise_radps": 0.1, "bias_radps": 0.2, "scale": 0.1}
    simulation = simulation_with(imu=imu, gnss=gnss, wheel_speeds=wheels)
    first = [observation.readings for observation in weave(simulation, 40)]
    simulation.reset()
    assert [observation.readings for observation in weave(simulation, 40)] == first


@pytest.mark.parametrize(
    "zone", [{"from_s": 1.0, "to_s": 3.0}, {"from_m": 10.0, "to_m": 30.0}], ids=["time", "stretch"]
)
def test_outage_has_no_fix_in_its_zone_alone(zone):
    route = Route(np.column_stack([np.arange(0.0, 101.0, 5.0), np.zeros(21)]))
    simulation = simulation_with(
        route=route, gnss={"period_s": TICK_S, "noise_m": 0.5, "outages": [zone]}
    )
    simulation.set_velocity(10.0, 0.0, 0.0)
    observations = []
    for _ in range(100):
        simulation.step(Command(throttle=0.4))
        observations.append(simulation.snapshot)
    for number, observation in enumerate(observations, start=1):
        in_time, on_stretch = 1.0 <= number * TICK_S < 3.0, 10.0 <= observation.state.x_m < 30.0
        inside = in_time if "from_s" in zone else on_stretch
        assert observation.readings.gnss.has_fix != inside
        if inside:
            assert observation.readings.gnss[:3] == (0.0, 0.0, 0.0)
    # The noise after the outage is that of a drive without it.
    free = simulation_with(route=route, gnss={"period_s": TICK_S, "noise_m": 0.5})
    free.set_velocity(10.0, 0.0, 0.0)
    for _ in range(100):
        free.step(Command(throttle=0.4))
    assert free.snapshot.readings == observations[-1].readings


def test_reflections_offset_the_position_in_their_zone_and_wander():
    zone = {"from_s": 2.0, "to_s": 40.0, "offset_m": 3.0}
    settings = sensor_settings("gnss", {"period_s": 0.5, "multipath": [zone]})
    drives = []
    for seed in range(40):
        gnss = Gnss(settings, SensorContext(seed, 1, 0.5, TESLA, None))
        readings = [gnss.read(Moment(0.5 * k, VehicleState()), k) for k in range(90)]
        drives.append([reading[:2] for reading in readings])
    offsets = np.array(drives)
    assert not offsets[:, :4].any()
    assert not offsets[:, 80:].any()
    values = offsets[:, 4:80]
    assert values.std() == pytest.approx(3.0, rel=0.15)
    step = (values[:, 1:] * values[:, :-1]).mean() / (values**2).mean()
    assert step == pytest.approx(math.exp(-0.5 / 5.0), abs=0.05)


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("gnss", {"period": 0.1}, "gnss: unknown key 'period'; did you mean 'period_s'?"),
        ("imu", {"rate_noise_radps": -1.0}, "imu: 'rate_noise_radps' must be a number from 0"),
        ("speedometer", 0.1, "speedometer must be a mapping with lines of 'key: value', got 0.1"),
        ("gnss", {"outages": [{"from_m": 5.0}]}, "gnss: entry 1 of 'outages' must be a zone with"),
    ],
)
def test_bad_setting_is_refused_by_its_name(name, values, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
        checked(name, values)


@pytest.mark.parametrize(
    ("zone", "message"),
    [
        ({"from_m": 10.0, "to_m": 80.0}, "80 m along a route of 50"),
        ({"from_s": 5.0, "to_s": 2.0}, "a zone of gnss must end after its start, got 5.0 to 2.0"),
    ],
)
def test_zone_off_the_drive_is_refused(zone, message):
    route = Route(np.array([[0.0, 0.0], [50.0, 0.0]]))
    with pytest.raises(ValueError, match=message):
        simulation_with(route=route, gnss={"period_s": 0.1, "outages": [zone]})


def test_one_kind_of_noise_does_not_depend_on_the_others():
    speed_alone, both = OdometryNoise(3, speed_mps=0.5), OdometryNoise(3, 0.1, speed_mps=0.5)
    speeds = [[noise.apply(TRUE).speed_mps for _ in range(3)] for noise in (speed_alone, both)]
    assert speeds[0] == speeds[1]


def test_sensors_of_one_drive_have_different_errors():
    sensors = [SensorErrors(7, number, [ErrorSizes(noise=1.0)], 0.1) for number in (1, 2)]
    first, second = ([sensor.apply([0.0], tick)[0] for tick in range(3)] for sensor in sensors)
    assert not set(first) & set(second)


def test_noise_has_its_sigmas_no_bias_and_no_correlation():
    noise = OdometryNoise(11, position_m=0.2, heading_rad=0.02, speed_mps=0.5)
    states = (noise.apply(TRUE) for _ in range(20000))
    errors = np.array([astuple(state)[:4] for state in states]) - astuple(TRUE)[:4]
    assert errors.std(axis=0) == pytest.approx([0.2, 0.2, 0.02, 0.5], rel=0.03)
    assert np.abs(errors.mean(axis=0) / [0.2, 0.2, 0.02, 0.5]).max() < 0.03
    assert np.abs(np.corrcoef(errors.T) - np.eye(4)).max() < 0.03
