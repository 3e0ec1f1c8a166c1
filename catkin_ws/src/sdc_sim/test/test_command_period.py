"""A stack that sends its commands at a rate of its own is not waited for in the ticks between."""

from sdc_sim.simulation.command_period import CommandPeriod


def drive(period, received):
    """Return in which ticks a command was due."""
    due = []
    for is_received in received:
        due.append(period.is_due)
        period.end_tick(is_received)
    return due


def test_stack_that_answers_each_tick_is_waited_for_in_each():
    assert all(drive(CommandPeriod(), [True] * 50))


def test_every_second_tick_is_learned_from_equal_gaps():
    due = drive(CommandPeriod(), [False, True] * 20)
    assert due[:10] == [True] * 10
    assert due[10:] == [False, True] * 15


def test_one_longer_gap_is_no_period():
    assert all(drive(CommandPeriod(), [True, True, False, True] * 20))


def test_command_before_its_time_shortens_the_period():
    period = CommandPeriod()
    drive(period, [False, False, True] * 5)
    assert period.ticks == 3
    drive(period, [False, True])
    assert period.ticks == 2


def test_stack_is_steady_after_ten_answers_until_it_misses_one():
    period = CommandPeriod()
    drive(period, [True] * 9)
    assert period.patience_factor == 1.0
    drive(period, [True])
    assert period.patience_factor == 40.0
    drive(period, [False])
    assert period.patience_factor == 1.0


def test_steady_stack_at_half_the_rate_is_not_waited_for_in_each_tick():
    period = CommandPeriod()
    drive(period, [False, True] * 20)
    assert period.patience_factor == 0.0
    drive(period, [False])
    assert period.patience_factor == 40.0
    drive(period, [False])
    assert period.patience_factor == 1.0


def test_stack_that_misses_its_time_is_waited_for_and_must_prove_its_period_longer():
    period = CommandPeriod()
    drive(period, [False, True] * 5)
    assert period.ticks == 2
    drive(period, [False, False, True])
    assert period.ticks == 1
    drive(period, [False, True] * 9)
    assert period.ticks == 1
    drive(period, [False, True])
    assert period.ticks == 2
