"""Pause, resume, step."""

import pytest

from sdc_sim.ros.services import PauseControl


@pytest.mark.parametrize(
    ("calls", "ticks"),
    [
        ([], 5),
        (["pause"], 0),
        (["pause", "resume"], 5),
        (["pause", "step", "step"], 2),
        (["step"], 1),
        (["step", "pause"], 0),
        (["step", "resume", "pause"], 0),
    ],
)
def test_pause_step_and_resume_decide_how_many_ticks_are_taken(calls, ticks):
    pause = PauseControl()
    for call in calls:
        getattr(pause, call)()
    assert pause.waiting == (ticks == 0)
    assert sum(pause.take() for _ in range(5)) == ticks
    assert pause.waiting == pause.paused == (ticks < 5)
