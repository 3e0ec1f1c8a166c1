"""Pause, resume, step: one test an edge."""

from sdc_sim.simulation.pause import PauseControl


def granted(pace, asked=5):
    return sum(pace.take() for _ in range(asked))


def test_runs_from_the_start():
    assert granted(PauseControl()) == 5


def test_pause_stops_and_resume_goes_on():
    pace = PauseControl()
    pace.pause()
    assert (granted(pace), pace.waiting) == (0, True)
    pace.resume()
    assert (granted(pace), pace.waiting) == (5, False)


def test_steps_are_counted():
    pace = PauseControl()
    pace.pause()
    pace.step()
    pace.step()
    assert not pace.waiting
    assert granted(pace) == 2
    assert pace.waiting


def test_a_step_pauses_a_running_world_after_one_tick():
    pace = PauseControl()
    pace.step()
    assert pace.paused
    assert granted(pace) == 1


def test_pause_and_resume_forget_the_steps_to_go():
    pace = PauseControl()
    pace.step()
    pace.pause()
    assert granted(pace) == 0
    pace.step()
    pace.resume()
    assert granted(pace) == 5
    pace.pause()
    assert granted(pace) == 0
