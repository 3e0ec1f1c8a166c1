"""Commands answer the observation that has their stamp, or else the last one."""

from sdc_sim.simulation.answer_tracker import UNSTAMPED, AnswerTracker

FIRST, SECOND, THIRD = (0, 50_000_000), (0, 100_000_000), (1, 0)
OF_ANOTHER_SIMULATION = (250, 0)


def answered(answers, stamp, observed):
    """Record a command; return whether it answers the observation."""
    if answers.is_repeated(stamp, observed):
        return False
    answers.record(stamp, observed)
    return answers.has_answer(observed, received=True)


def test_command_with_the_stamp_of_the_observation_answers_it():
    answers = AnswerTracker()
    assert not answers.has_answer(FIRST, received=False)
    assert answered(answers, FIRST, FIRST)
    assert answers.by_stamp
    assert not answers.has_answer(SECOND, received=False)


def test_first_command_after_the_observation_answers_it_while_there_are_no_stamps():
    answers = AnswerTracker()
    assert answered(answers, UNSTAMPED, FIRST)
    assert not answers.has_answer(SECOND, received=False)
    assert answered(answers, UNSTAMPED, SECOND)
    assert not answers.by_stamp


def test_command_of_an_earlier_tick_shows_that_stamps_count_and_answers_nothing():
    answers = AnswerTracker()
    assert not answered(answers, FIRST, SECOND)
    assert answers.by_stamp
    assert answered(answers, SECOND, SECOND)


def test_command_without_a_stamp_answers_nothing_among_stamped_ones():
    answers = AnswerTracker()
    assert answered(answers, UNSTAMPED, FIRST)
    assert answered(answers, SECOND, SECOND)
    assert not answered(answers, UNSTAMPED, THIRD)
    assert not answers.stamped


def test_repeated_and_earlier_answers_are_recognized():
    answers = AnswerTracker()
    answers.record(SECOND, SECOND)
    assert answers.is_repeated(SECOND, SECOND)
    assert answers.is_repeated(FIRST, SECOND)
    assert not answers.is_repeated(THIRD, THIRD)
    assert not answers.is_repeated(UNSTAMPED, SECOND)


def test_latched_command_of_another_simulation_does_not_hide_the_answers():
    answers = AnswerTracker()
    assert not answered(answers, OF_ANOTHER_SIMULATION, FIRST)
    assert not answers.by_stamp
    assert answered(answers, FIRST, FIRST)


def test_stamps_of_another_clock_count_as_none_after_a_tick_without_an_answer():
    answers = AnswerTracker()
    assert not answered(answers, OF_ANOTHER_SIMULATION, FIRST)
    answers.give_up(FIRST)
    assert answered(answers, OF_ANOTHER_SIMULATION, SECOND)


def test_order_decides_when_stamps_are_one_tick_late():
    answers = AnswerTracker()
    assert answered(answers, FIRST, FIRST)
    assert not answered(answers, FIRST, SECOND)
    answers.give_up(SECOND)
    assert not answers.by_stamp
    assert answered(answers, SECOND, THIRD)
    assert not answers.by_stamp


def test_order_decides_when_single_ticks_have_no_command():
    answers = AnswerTracker()
    for tick in range(1, 8):
        stamp = (0, tick * 50_000_000)
        if tick % 2:
            assert answered(answers, stamp, stamp)
        else:
            assert answers.by_stamp
            answers.give_up(stamp)
    assert not answers.by_stamp


def test_stack_that_stops_for_many_ticks_is_still_matched_by_stamp():
    answers = AnswerTracker()
    assert answered(answers, FIRST, FIRST)
    for tick in range(2, 100):
        assert not answered(answers, UNSTAMPED, (0, tick * 50_000_000))
        answers.give_up((0, tick * 50_000_000))
    assert answers.by_stamp
