import json
import math
import os

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sdc_sim.physics.ackermann import AckermannControl, AckermannGains, AckermannTarget
from sdc_sim.physics.collision import overlap
from sdc_sim.physics.obstacles import KINDS, ObstaclePlan, Obstacles
from sdc_sim.physics.vehicle import Vehicle, VehicleCommand, load_vehicle
from sdc_sim.simulation.sensors import OdometryNoise
from sdc_sim.simulation.simulation import Simulation

TESLA = os.path.join(os.path.dirname(__file__), "..", "config", "vehicles", "tesla_model3.yaml")


def world(patience_s=1.0, **others):
    return Simulation(Vehicle(load_vehicle(TESLA)), 0.05, patience_s, **others)


def wall_at(x_m, y_m=0.0, yaw_rad=0.0, kind="obstacle"):
    return Obstacles([ObstaclePlan.standing(kind, x_m, y_m, yaw_rad)])


def drive(here, seconds, **command):
    touches = []
    for _ in range(round(seconds / here.tick_s)):
        here.obey(VehicleCommand(**command))
        touches += here.advance()
    return touches


def test_stamps_are_whole_ticks_without_drift():
    here = world()
    assert here.stamp == (0, 50_000_000)
    here.tick = 72_000_000
    assert here.stamp == (3_600_000, 0)


def test_car_waits_for_its_first_command_without_braking():
    here = world()
    for _ in range(100):
        here.advance()
    assert not here.silent
    assert here.vehicle.state.x_m == 0.0


@pytest.mark.parametrize(("patience_s", "stops"), [(1.0, True), (0.0, False)])
def test_silence(patience_s, stops):
    here = world(patience_s)
    for _ in range(60):
        here.obey(VehicleCommand(throttle=0.8))
        here.advance()
    for _ in range(100):
        here.advance()
    assert here.silent == stops
    assert (here.vehicle.state.speed_mps == 0.0) == stops


def test_refused_command_leaves_the_last_one_in_force():
    here = world()
    here.obey(VehicleCommand(throttle=0.8))
    with pytest.raises(ValueError, match="throttle|finite|nan"):
        here.obey(VehicleCommand(throttle=math.nan))
    for _ in range(15):
        here.advance()
    assert here.vehicle.state.speed_mps > 1.0


def test_out_of_range_is_clamped_and_said():
    here = world()
    assert here.obey(VehicleCommand(throttle=7.0))
    assert not here.obey(VehicleCommand(throttle=0.7))


@pytest.mark.parametrize(
    ("tick_s", "patience_s"), [(0.0, 1.0), (-1.0, 1.0), (math.nan, 1.0), (0.05, -1.0)]
)
def test_senseless_times_are_refused(tick_s, patience_s):
    with pytest.raises(ValueError, match="_s must"):
        Simulation(Vehicle(load_vehicle(TESLA)), tick_s, patience_s)


def test_car_stops_at_an_obstacle_with_one_touch_and_its_momentum():
    here = world(obstacles=wall_at(30.0))
    speeds = []
    touches = []
    for _ in range(200):
        speeds.append(here.vehicle.state.speed_mps)
        touches += drive(here, 0.05, throttle=0.6)
    (touch,) = touches
    assert touch.id == here.obstacles.bodies[0].id
    assert touch.impulse_x_ns == pytest.approx(-1845.0 * max(speeds), rel=0.05)
    assert touch.impulse_y_ns == pytest.approx(0.0, abs=1.0)
    assert here.vehicle.state.speed_mps == pytest.approx(0.0, abs=0.2)
    assert here.vehicle.state.x_m == pytest.approx(30.0 - 0.5 - 2.35, abs=0.01)


def test_car_backs_off_an_obstacle_and_touches_it_anew():
    here = world(obstacles=wall_at(10.0))
    assert len(drive(here, 5.0, throttle=0.6)) == 1
    assert drive(here, 5.0, throttle=0.6, reverse=True) == []
    assert here.vehicle.state.x_m < 5.0
    assert len(drive(here, 20.0, throttle=0.6)) == 1


def test_nothing_touched_leaves_the_drive_as_it_was_to_the_bit():
    alone, beside = world(), world(obstacles=wall_at(30.0, 2.6))
    for here in (alone, beside):
        assert drive(here, 8.0, throttle=0.6) == []
    assert alone.vehicle.state == beside.vehicle.state


def test_pedestrian_who_walks_into_the_standing_car_stops_and_is_told():
    walker = ObstaclePlan(
        "pedestrian", ((0.0, -5.0), (0.0, 5.0)), KINDS["pedestrian"][:3], speed_mps=1.5
    )
    here = world(obstacles=Obstacles([walker]))
    (touch,) = drive(here, 8.0, brake=1.0)
    assert touch.impulse_y_ns == pytest.approx(75.0 * 1.5)
    assert here.vehicle.state.y_m == 0.0


def test_car_is_not_put_where_an_obstacle_stands():
    with pytest.raises(ValueError, match="pedestrian at"):
        world(obstacles=wall_at(2.0, kind="pedestrian"))
    here = world(obstacles=wall_at(10.0))
    with pytest.raises(ValueError, match="obstacle at"):
        here.place(9.0, 0.0, 0.0)
    assert here.vehicle.state.x_m == 0.0


@settings(max_examples=60, deadline=None)
@given(
    st.floats(0.0, 40.0),
    st.floats(-math.pi, math.pi),
    st.floats(-1.0, 1.0),
    st.floats(-1.4, 1.4),
    st.floats(0.0, math.pi),
    st.sampled_from(sorted(KINDS)),
)
def test_no_drive_enters_an_obstacle_or_gains_speed_from_it(
    speed_mps, heading, steer, aside_m, yaw, kind
):
    here = world(patience_s=0.0)
    here.vehicle.reset(0.0, 0.0, heading, speed_mps)
    c, s = math.cos(heading), math.sin(heading)
    here.obstacles = wall_at(12.0 * c - aside_m * s, 12.0 * s + aside_m * c, yaw, kind)
    body = here.obstacles.bodies[0]
    assert overlap(here.car, body.rectangle) is None
    here.obey(VehicleCommand(steer=steer))
    for _ in range(60):
        before = math.hypot(here.vehicle.state.speed_mps, here.vehicle.state.lateral_speed_mps)
        touches = here.advance()
        assert overlap(here.car, body.rectangle) is None
        after = math.hypot(here.vehicle.state.speed_mps, here.vehicle.state.lateral_speed_mps)
        if touches:
            assert after <= before + 0.1
            assert math.hypot(touches[0].impulse_x_ns, touches[0].impulse_y_ns) <= 1845.0 * (
                before + 0.1
            )


def test_reset_brings_car_and_obstacles_back_and_lets_time_go_on():
    walker = ObstaclePlan(
        "pedestrian",
        ((20.0, -5.0), (20.0, 5.0)),
        KINDS["pedestrian"][:3],
        speed_mps=1.0,
        start_s=1.0,
    )
    here = world(start=(1.0, 2.0, 0.5), obstacles=Obstacles([walker]))

    def course():
        drive(here, 3.0, throttle=0.6)
        return here.vehicle.state, here.obstacles.bodies

    first = course()
    tick = here.tick
    here.reset()
    assert here.tick == tick
    assert (here.vehicle.state.x_m, here.vehicle.state.y_m, here.vehicle.state.yaw_rad) == (
        1.0,
        2.0,
        0.5,
    )
    assert course() == first


def test_place_forgets_the_command():
    here = world()
    drive(here, 3.0, throttle=0.8)
    here.place(50.0, 60.0, 1.0)
    here.advance()
    assert (here.vehicle.state.x_m, here.vehicle.state.y_m, here.vehicle.state.speed_mps) == (
        50.0,
        60.0,
        0.0,
    )
    with pytest.raises(ValueError, match="x_m"):
        here.place(math.nan, 0.0, 0.0)


def test_senses_are_late_by_whole_ticks_with_the_stamp_of_what_they_show():
    now, late = world(), world(sensor_latency_s=0.15)
    assert late.sensed.stamp == (0, 50_000_000)
    assert late.stamp == (0, 200_000_000)
    states = []
    for _ in range(60):
        drive(now, 0.05, throttle=0.7)
        drive(late, 0.05, throttle=0.7)
        states.append(now.sensed.state)
    assert late.sensed.state == states[-4]
    assert late.tick - 3 == late.sensed.stamp[0] * 20 + late.sensed.stamp[1] // 50_000_000


def test_commands_are_late_by_whole_ticks():
    now, late = world(), world(command_latency_s=0.1)
    drive(now, 1.0, throttle=0.7)
    drive(late, 1.1, throttle=0.7)
    assert late.vehicle.state.speed_mps == pytest.approx(now.vehicle.state.speed_mps)
    assert late.vehicle.state.speed_mps > 0.5


def test_noise_is_in_what_is_measured_and_the_truth_stays():
    noisy, clear = world(noise=OdometryNoise(7, 0.1, 0.01, 0.2)), world(noise=OdometryNoise(7))
    drive(noisy, 2.0, throttle=0.7)
    drive(clear, 2.0, throttle=0.7)
    assert noisy.sensed.state == clear.sensed.state == clear.sensed.measured
    assert 1e-4 < abs(noisy.sensed.measured.x_m - noisy.sensed.state.x_m) < 1.0


def rich_world():
    """A world with all there is to remember."""
    car = Vehicle(load_vehicle(TESLA))
    plans = [
        ObstaclePlan(
            "pedestrian",
            ((15.0, -3.0), (15.0, 3.0)),
            (0.5, 0.5, 1.75),
            speed_mps=1.4,
            trigger_m=12.0,
        ),
        ObstaclePlan(
            "car",
            ((40.0, 0.0), (60.0, 0.0), (60.0, 20.0)),
            (4.7, 2.0, 1.45),
            speed_mps=3.0,
            start_s=0.5,
        ),
        ObstaclePlan.standing("obstacle", 10.0, 5.0, 0.3),
    ]
    gains = AckermannGains(1.5, 0.4, 3.0, 6.0, 60.0, 0.15, 0.3)
    return Simulation(
        car,
        0.05,
        0.4,
        obstacles=Obstacles(plans),
        noise=OdometryNoise(3, 0.05, 0.01, 0.1),
        ackermann=AckermannControl(car.parameters, gains),
        command_latency_s=0.1,
        sensor_latency_s=0.15,
    )


DEEDS = st.one_of(
    st.tuples(st.just("tick"), st.integers(1, 30)),
    st.tuples(st.just("pedals"), st.floats(0.0, 1.0), st.floats(-1.0, 1.0), st.booleans()),
    st.tuples(st.just("ackermann"), st.floats(-0.5, 0.5), st.floats(-5.0, 15.0)),
    st.tuples(st.just("by_hand"), st.booleans()),
    st.tuples(st.just("click"), st.floats(5.0, 50.0), st.floats(-2.0, 6.0)),
    st.tuples(st.just("reset")),
)


def do(here, deed, *values):
    if deed == "tick":
        return [here.advance() for _ in range(values[0])]
    if deed == "pedals":
        return here.obey(VehicleCommand(values[0], values[1]), by_hand=values[2])
    if deed == "ackermann":
        return here.obey_ackermann(AckermannTarget(values[0], 0.0, values[1]))
    if deed == "by_hand":
        return here.take_over(values[0])
    try:
        return (
            here.toggle_obstacle(ObstaclePlan.standing("car", values[0], values[1], 0.1))
            if deed == "click"
            else here.reset()
        )
    except ValueError as error:
        return str(error)


@settings(max_examples=60)
@given(before=st.lists(DEEDS, max_size=12), after=st.lists(DEEDS, min_size=1, max_size=12))
def test_another_world_goes_on_from_the_memory_bit_for_bit(before, after):
    first, second = rich_world(), rich_world()
    for deed in before:
        do(first, *deed)
    second.recall(json.loads(json.dumps(first.memory())))
    assert (second.stamp, second.sensed, second.vehicle.state) == (
        first.stamp,
        first.sensed,
        first.vehicle.state,
    )
    for deed in after:
        assert do(second, *deed) == do(first, *deed)
        assert second.memory() == first.memory()
        assert second.sensed == first.sensed


def test_a_silent_car_keeps_its_wheel_where_it_is():
    here = world(0.4)
    drive(here, 4.0, throttle=0.6, steer=0.3)
    for _ in range(10):
        here.advance()
    assert here.silent
    assert here.control.last == VehicleCommand(steer=0.3, brake=1.0)
