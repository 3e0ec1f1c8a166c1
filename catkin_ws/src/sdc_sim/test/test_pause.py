"""Pause, resume, step: one test for each transition."""

from sdc_sim.simulation.pause import PauseControl


def allowed(pause, ticks=5):
    return sum(pause.take() for _ in range(ticks))


def test_runs_at_the_start():
    assert allowed(PauseControl()) == 5


def test_pause_stops_and_resume_continues():
    pause = PauseControl()
    pause.pause()
    assert (allowed(pause), pause.waiting) == (0, True)
    pause.resume()
    assert (allowed(pause), pause.waiting) == (5, False)


def test_steps_are_counted():
    pause = PauseControl()
    pause.pause()
    pause.step()
    pause.step()
    assert not pause.waiting
    assert allowed(pause) == 2
    assert pause.waiting


def test_step_pauses_a_running_simulation_after_one_tick():
    pause = PauseControl()
    pause.step()
    assert pause.paused
    assert allowed(pause) == 1


def test_pause_and_resume_forget_the_remaining_steps():
    pause = PauseControl()
    pause.step()
    pause.pause()
    assert allowed(pause) == 0
    pause.step()
    pause.resume()
    assert allowed(pause) == 5
    pause.pause()
    assert allowed(pause) == 0
