"""Commands: their limits, which one is executed, whose it is, and which tick it answers."""

import dataclasses
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from presets import TESLA

from sdc_common.driving import Command
from sdc_sim.physics.ackermann import AckermannControl, AckermannGains, AckermannTarget
from sdc_sim.physics.vehicle import Vehicle, VehicleState
from sdc_sim.sensors.errors import DelayLine
from sdc_sim.simulation.command_mux import AnswerTracker, CommandArbiter, CommandMux
from sdc_sim.simulation.simulation import Simulation
from sdc_sim.yaml_document import packaged_config

TICK_S = 0.05
AT_REST = VehicleState()
SOFTWARE, MANUAL = Command(throttle=0.5), Command(throttle=0.2, steer=0.1)
FULL_BRAKE = Command(brake=1.0)


def make_mux(latency_s=0.0, timeout_ticks=20):
    control = AckermannControl(TESLA, AckermannGains(**packaged_config("sim")["ackermann"]))
    return CommandMux(timeout_ticks, DelayLine(latency_s, TICK_S), control)


COAST, TARGET = Command(), AckermannTarget(steering_angle_rad=0.3, speed_mps=5.0)


@pytest.mark.parametrize(
    ("events", "tick", "executed"),
    [
        ([], 500, COAST),
        # The last command stays in force until the timeout of 20 ticks.
        ([("software", 1)], 21, SOFTWARE),
        ([("software", 1)], 22, FULL_BRAKE),
        ([("software", 1), ("software", 23)], 23, SOFTWARE),
        ([("target", 1)], 50, FULL_BRAKE),
        # The later of pedals and target applies.
        ([("target", 2), ("software", 3)], 3, SOFTWARE),
        # Manual commands count only during the override, and none from before it.
        ([("software", 1), ("manual", 1)], 1, SOFTWARE),
        ([("software", 1), ("manual", 1), ("on", 2)], 2, COAST),
        ([("on", 2), ("manual", 3), ("software", 3)], 3, MANUAL),
        ([("on", 1), ("manual", 2), ("on", 3)], 3, MANUAL),
        ([("on", 1), ("manual", 2), ("software", 3), ("off", 4)], 4, SOFTWARE),
        ([("software", 1), ("on", 2), ("off", 4)], 4, SOFTWARE),
        # An override without a manual command times out, too.
        ([("software", 100), ("on", 100)], 120, COAST),
        ([("on", 100), ("software", 121)], 121, FULL_BRAKE),
    ],
)
def test_executed_command_follows_from_the_commands_before(events, tick, executed):
    mux = make_mux()
    commands = {"software": SOFTWARE, "manual": MANUAL, "target": TARGET}
    for event, at in events:
        if event in commands:
            mux.accept(commands[event], at, manual=event == "manual")
        else:
            mux.set_manual_override(event == "on", at)
    assert mux.select(tick, AT_REST, TICK_S) == executed


def test_ackermann_control_is_reset_after_pedals():
    used, new = make_mux(), make_mux()
    for tick in range(1, 40):
        used.accept(AckermannTarget(speed_mps=5.0), tick)
        used.select(tick, AT_REST, TICK_S)
    used.accept(SOFTWARE, 40)
    used.select(40, AT_REST, TICK_S)
    for mux in (used, new):
        mux.accept(AckermannTarget(speed_mps=1.0), 41)
    assert used.select(41, AT_REST, TICK_S) == new.select(41, AT_REST, TICK_S)


def test_latency_delays_commands_but_not_the_braking_after_a_timeout():
    mux = make_mux(latency_s=0.15)
    executed = []
    for tick in range(1, 6):
        mux.accept(Command(throttle=tick / 10.0), tick)
        executed.append(mux.select(tick, AT_REST, TICK_S).throttle)
    assert executed == [0.0, 0.0, 0.0, 0.1, 0.2]
    assert mux.select(26, AT_REST, TICK_S) == FULL_BRAKE


@pytest.mark.parametrize("manual", [False, True])
def test_steering_keeps_its_position_while_the_commands_time_out(manual):
    mux = make_mux()
    mux.set_manual_override(manual, 1)
    mux.accept(Command(throttle=0.5, steer=-0.3), 1, manual)
    mux.select(2, AT_REST, TICK_S)
    held = Command(steer=-0.3, brake=1.0)
    assert [mux.select(tick, AT_REST, TICK_S) for tick in (22, 23, 200)] == [held] * 3


def test_refused_command_changes_nothing():
    mux = make_mux()
    mux.accept(SOFTWARE, 1)
    with pytest.raises(ValueError, match="throttle"):
        mux.accept(Command(throttle=math.nan), 2)
    with pytest.raises(ValueError, match="speed_mps"):
        mux.accept(AckermannTarget(speed_mps=math.inf), 2)
    assert mux.select(2, AT_REST, TICK_S) == SOFTWARE


def test_reset_forgets_commands_and_keeps_the_override():
    mux = make_mux(latency_s=0.1)
    mux.set_manual_override(True, 1)
    mux.accept(MANUAL, 1, manual=True)
    mux.select(1, AT_REST, TICK_S)
    mux.reset()
    assert mux.manual_override
    assert [mux.select(tick, AT_REST, TICK_S) for tick in (2, 3, 4)] == [Command()] * 3


ANY_NUMBER = st.floats(width=32)
ANY_COMMAND = st.builds(Command, ANY_NUMBER, ANY_NUMBER, ANY_NUMBER, st.booleans(), st.booleans())


@pytest.mark.slow(6)
@settings(max_examples=max(200, settings.default.max_examples))
@given(st.lists(st.tuples(ANY_COMMAND, st.booleans()), min_size=1, max_size=8))
def test_fuzz_any_commands_execute_as_valid_pedals(commands):
    simulation = Simulation(Vehicle(TESLA), TICK_S, 0.4)
    for command, manual in commands:
        before = simulation.commands.executed
        numbers = (command.throttle, command.brake, command.steer)
        try:
            clamped = simulation.accept(command, manual)
        except ValueError as error:
            assert not all(map(math.isfinite, numbers)), error
        else:
            assert all(map(math.isfinite, numbers))
            pedals_valid = 0.0 <= command.throttle <= 1.0 and 0.0 <= command.brake <= 1.0
            assert clamped == (not (pedals_valid and -1.0 <= command.steer <= 1.0))
        assert simulation.commands.executed == before, "a command is executed in the next step"
        simulation.step()
        executed = simulation.commands.executed
        assert 0.0 <= executed.throttle <= 1.0 and 0.0 <= executed.brake <= 1.0
        assert -1.0 <= executed.steer <= 1.0
        assert all(map(math.isfinite, vars(simulation.vehicle.state).values()))


@pytest.mark.parametrize("key", ["throttle", "steer", "brake"])
def test_value_out_of_its_range_is_limited_and_reported(key):
    command, least = Command(0.2, 0.1, 0.3, True, True), -1.0 if key == "steer" else 0.0
    for value, limit in ((1.5, 1.0), (least - 0.5, least)):
        limited = dataclasses.replace(command, **{key: value}).clamped()
        assert limited == (dataclasses.replace(command, **{key: limit}), True)


def test_first_publisher_keeps_control_until_it_has_been_silent_or_control_is_released():
    arbiter = CommandArbiter(timeout_ticks=8)
    for tick in range(100):
        assert arbiter.admits("/first", tick)
        assert not arbiter.admits("/second", tick)
    assert arbiter.active == "/first"
    assert not arbiter.admits("/second", 107)
    assert arbiter.admits("/second", 108)
    assert not arbiter.admits("/first", 109)
    arbiter.release()
    assert arbiter.admits("/first", 110)


TICK_NS = 50_000_000
OTHER_CLOCK = 1_700_000_000


def answered_ticks(*ticks):
    """Return whether each tick has been answered.

    Args:
        ticks: for each, the ticks whose stamps its commands have; 0 is none
    """
    answers, answered = AnswerTracker(), []
    for tick, stamps in enumerate(ticks, start=1):
        answers.expect()
        for stamp in stamps:
            if not answers.is_repeated(stamp * TICK_NS, tick * TICK_NS):
                answers.record(stamp * TICK_NS, tick * TICK_NS)
        if not answers.answered:
            answers.give_up()
        answered.append(answers.answered)
    return answered


@pytest.mark.parametrize(
    ("ticks", "answered"),
    [
        ([[1], [2], [3]], [1, 1, 1]),
        ([[0], [0], [0]], [1, 1, 1]),
        ([[], [2], []], [0, 1, 0]),
        # An older, a repeated or a later command answers nothing; the next one with the stamp does.
        ([[], [1, 2]], [0, 1]),
        ([[1], [1, 2]], [1, 1]),
        ([[1], [9, 2]], [1, 1]),
        ([[1, 1], [2]], [1, 1]),
        # A brake command without a stamp, as of a controller whose path is missing.
        ([[1], [0], [3]], [1, 1, 1]),
        # Stamps of the wall clock, and stamps that are one tick late, count as none after one tick.
        ([[OTHER_CLOCK], [OTHER_CLOCK], [OTHER_CLOCK]], [0, 1, 1]),
        ([[1], [1], [2], [3]], [1, 0, 1, 1]),
        # A stack that sent nothing for some ticks is still matched by stamp.
        ([[1], [], [], [4], [4, 5]], [1, 0, 0, 1, 1]),
    ],
)
def test_commands_answer_by_stamp_or_else_by_order(ticks, answered):
    assert answered_ticks(*ticks) == list(map(bool, answered))
