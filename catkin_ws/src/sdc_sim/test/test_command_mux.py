"""Who drives: one test an edge of the changes between software and person, pedals and Ackermann, silence and orders."""

from __future__ import annotations

import math
import os

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sdc_sim.physics.ackermann import AckermannControl, AckermannGains, AckermannTarget
from sdc_sim.physics.vehicle import Vehicle, VehicleCommand, VehicleState, load_vehicle
from sdc_sim.simulation.command_mux import CommandMux
from sdc_sim.simulation.sensors import DelayLine
from sdc_sim.simulation.simulation import Simulation

TESLA = load_vehicle(
    os.path.join(
        os.path.dirname(os.path.abspath(__file__)), "..", "config", "vehicles", "tesla_model3.yaml"
    )
)
TICK_S = 0.05
STILL = VehicleState()
SOFTWARE, PERSON = VehicleCommand(throttle=0.5), VehicleCommand(throttle=0.2, steer=0.1)
BRAKES = VehicleCommand(brake=1.0)


def control(latency_s=0.0, patience_ticks=20):
    return CommandMux(
        patience_ticks,
        DelayLine(latency_s, TICK_S),
        AckermannControl(TESLA, AckermannGains(1.5, 0.4, 3.0, 6.0, 60.0, 0.15, 0.3)),
    )


def test_before_the_first_order_the_car_coasts():
    assert control().command(500, STILL, TICK_S) == VehicleCommand()


def test_the_last_order_stays_in_force_until_silence():
    driver = control()
    driver.obey(SOFTWARE, 1)
    assert driver.command(21, STILL, TICK_S) == SOFTWARE
    assert driver.command(22, STILL, TICK_S) == BRAKES
    driver.obey(SOFTWARE, 23)
    assert driver.command(23, STILL, TICK_S) == SOFTWARE


def test_patience_of_zero_is_for_ever():
    driver = control(patience_ticks=0)
    driver.obey(SOFTWARE, 1)
    assert driver.command(10**6, STILL, TICK_S) == SOFTWARE


def test_a_persons_orders_count_only_while_overriding():
    driver = control()
    driver.obey(SOFTWARE, 1)
    driver.obey(PERSON, 1, by_hand=True)
    assert driver.command(1, STILL, TICK_S) == SOFTWARE
    driver.take_over(True, 2)
    assert driver.command(2, STILL, TICK_S) == VehicleCommand(), (
        "orders from before the override do not count"
    )
    driver.obey(PERSON, 3, by_hand=True)
    driver.obey(SOFTWARE, 3)
    assert driver.command(3, STILL, TICK_S) == PERSON


def test_given_back_the_car_obeys_the_softwares_latest_order():
    driver = control()
    driver.take_over(True, 1)
    driver.obey(PERSON, 2, by_hand=True)
    driver.obey(SOFTWARE, 3)
    driver.take_over(False, 4)
    assert driver.command(4, STILL, TICK_S) == SOFTWARE


def test_a_person_who_repeats_the_override_keeps_the_order():
    driver = control()
    driver.take_over(True, 1)
    driver.obey(PERSON, 2, by_hand=True)
    driver.take_over(True, 3)
    assert driver.command(3, STILL, TICK_S) == PERSON


def test_a_person_who_takes_over_and_does_nothing_brakes():
    driver = control()
    driver.obey(SOFTWARE, 100)
    driver.take_over(True, 100)
    assert driver.command(120, STILL, TICK_S) == VehicleCommand()
    driver.obey(SOFTWARE, 121)
    assert driver.command(121, STILL, TICK_S) == BRAKES


def test_the_later_of_pedals_and_ackermann_rules():
    driver = control()
    driver.obey(SOFTWARE, 1)
    driver.obey_ackermann(AckermannTarget(steering_angle_rad=0.3, speed_mps=5.0), 2)
    assert driver.command(2, STILL, TICK_S).steer < 0.0
    driver.obey(SOFTWARE, 3)
    assert driver.command(3, STILL, TICK_S) == SOFTWARE


def test_ackermann_silence_brakes():
    driver = control()
    driver.obey_ackermann(AckermannTarget(speed_mps=5.0), 1)
    assert driver.command(50, STILL, TICK_S) == BRAKES


def test_ackermann_starts_anew_after_pedals():
    driver, fresh = control(), control()
    for tick in range(1, 40):
        driver.obey_ackermann(AckermannTarget(speed_mps=5.0), tick)
        driver.command(tick, STILL, TICK_S)
    driver.obey(SOFTWARE, 40)
    driver.command(40, STILL, TICK_S)
    for each in (driver, fresh):
        each.obey_ackermann(AckermannTarget(speed_mps=1.0), 41)
    assert driver.command(41, STILL, TICK_S) == fresh.command(41, STILL, TICK_S)


def test_latency_delays_orders_by_whole_ticks_but_not_the_emergency():
    driver = control(latency_s=0.15)
    given = []
    for tick in range(1, 6):
        driver.obey(VehicleCommand(throttle=tick / 10.0), tick)
        given.append(driver.command(tick, STILL, TICK_S).throttle)
    assert given == [0.0, 0.0, 0.0, 0.1, 0.2]
    assert driver.command(26, STILL, TICK_S) == BRAKES


def test_refused_orders_change_nothing():
    driver = control()
    driver.obey(SOFTWARE, 1)
    with pytest.raises(ValueError, match="throttle"):
        driver.obey(VehicleCommand(throttle=math.nan), 2)
    with pytest.raises(ValueError, match="speed_mps"):
        driver.obey_ackermann(AckermannTarget(speed_mps=math.inf), 2)
    assert driver.command(2, STILL, TICK_S) == SOFTWARE


def test_reset_forgets_orders_but_not_who_drives():
    driver = control(latency_s=0.1)
    driver.take_over(True, 1)
    driver.obey(PERSON, 1, by_hand=True)
    driver.command(1, STILL, TICK_S)
    driver.reset()
    assert driver.by_hand
    assert [driver.command(tick, STILL, TICK_S) for tick in (2, 3, 4)] == [VehicleCommand()] * 3


FIGURE = st.floats(width=32)
COMMANDS = st.builds(VehicleCommand, FIGURE, FIGURE, FIGURE, st.booleans(), st.booleans())


@settings(max_examples=max(500, settings.default.max_examples))
@given(st.lists(st.tuples(COMMANDS, st.booleans()), min_size=1, max_size=8))
def test_fuzz_whatever_is_commanded_the_car_obeys_sane_pedals(orders):
    world = Simulation(Vehicle(TESLA), TICK_S, 0.4)
    for command, by_hand in orders:
        before = world.control.last
        figures = (command.throttle, command.brake, command.steer)
        try:
            clamped = world.obey(command, by_hand)
        except ValueError as error:
            assert not all(map(math.isfinite, figures)), error
            clamped = False
        else:
            assert all(map(math.isfinite, figures))
            assert clamped == (
                not (
                    0.0 <= command.throttle <= 1.0
                    and 0.0 <= command.brake <= 1.0
                    and -1.0 <= command.steer <= 1.0
                )
            )
        assert world.control.last == before, "an order is obeyed in the tick, not before"
        world.advance()
        last = world.control.last
        assert (
            0.0 <= last.throttle <= 1.0 and 0.0 <= last.brake <= 1.0 and -1.0 <= last.steer <= 1.0
        )
        assert all(map(math.isfinite, vars(world.vehicle.state).values()))
