from hypothesis import given
from hypothesis import strategies as st

from sdc_sim.evaluation.command_matching import CommandMatching


def test_all_answered_but_the_last():
    answers = CommandMatching()
    for stamp in range(1, 6):
        assert answers.ask(stamp)
        answers.answer(stamp)
    answers.ask(6)
    assert (answers.asked, answers.missed) == (6, 0)


def test_repeated_odometry_is_no_tick():
    answers = CommandMatching()
    assert answers.ask(1)
    assert not answers.ask(1)
    assert answers.asked == 1


def test_unstamped_commands_answer_nothing():
    answers = CommandMatching()
    for stamp in range(1, 11):
        answers.ask(stamp)
        answers.answer(0)
    assert answers.missed == 9


@given(st.sets(st.integers(1, 50)), st.randoms())
def test_order_of_hearing_does_not_matter(lost, random):
    answers = CommandMatching()
    events = [("ask", stamp) for stamp in range(1, 52)]
    for stamp in range(1, 51):
        if stamp not in lost:
            place = max(0, min(len(events), events.index(("ask", stamp)) + random.randint(-3, 4)))
            events.insert(place, ("answer", stamp))
    for kind, stamp in events:
        getattr(answers, kind)(stamp)
    assert answers.asked == 51
    assert answers.missed == len(lost)


def test_memory_is_bounded():
    answers = CommandMatching()
    for stamp in range(1, 100_001):
        answers.ask(stamp)
        answers.answer(-stamp)
    assert len(answers._open) + len(answers._early) < 5000
    assert answers.missed == 99_999
