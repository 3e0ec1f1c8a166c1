"""Commands answer the observation that has their stamp."""

from sdc_sim.simulation.answer_tracker import UNSTAMPED, AnswerTracker

FIRST, SECOND, THIRD = (0, 50_000_000), (0, 100_000_000), (1, 0)


def test_command_with_the_stamp_of_the_observation_answers_it():
    answers = AnswerTracker()
    assert not answers.has_answer(FIRST)
    answers.record(FIRST, FIRST)
    assert answers.has_answer(FIRST)
    assert not answers.has_answer(SECOND)


def test_command_without_a_stamp_answers_nothing():
    answers = AnswerTracker()
    answers.record(UNSTAMPED, FIRST)
    assert not answers.has_answer(FIRST)
    assert not answers.stamped


def test_command_of_an_earlier_tick_answers_nothing():
    answers = AnswerTracker()
    answers.record(FIRST, SECOND)
    assert answers.stamped
    assert not answers.has_answer(SECOND)


def test_repeated_and_earlier_answers_are_recognized():
    answers = AnswerTracker()
    answers.record(SECOND, SECOND)
    assert answers.is_repeated(SECOND)
    assert answers.is_repeated(FIRST)
    assert not answers.is_repeated(THIRD)
    assert not answers.is_repeated(UNSTAMPED)


def test_latched_command_of_another_simulation_does_not_hide_the_answers():
    answers = AnswerTracker()
    answers.record((250, 0), FIRST)
    assert not answers.has_answer(FIRST)
    assert not answers.is_repeated(FIRST)
    answers.record(FIRST, FIRST)
    assert answers.has_answer(FIRST)


def test_restored_checkpoint_knows_what_was_answered():
    answers, restored = AnswerTracker(), AnswerTracker()
    answers.record(SECOND, SECOND)
    restored.restore(*answers.checkpoint())
    assert restored.stamped
    assert restored.is_repeated(SECOND)
    assert not restored.is_repeated(THIRD)
