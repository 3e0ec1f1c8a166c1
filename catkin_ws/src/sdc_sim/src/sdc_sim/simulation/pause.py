"""Pause, resume and single steps of the simulation."""

from __future__ import annotations


class PauseControl:
    """Runs, is paused, or is paused with some steps left to take."""

    def __init__(self) -> None:
        self.paused = False
        self._steps = 0

    @property
    def waiting(self) -> bool:
        """Whether the next tick has to wait for `resume` or `step`."""
        return self.paused and self._steps == 0

    def pause(self) -> None:
        """Pause after the present tick."""
        self.paused = True
        self._steps = 0

    def resume(self) -> None:
        """Run."""
        self.paused = False
        self._steps = 0

    def step(self) -> None:
        """Allow one more tick, then pause; a running simulation pauses after it."""
        self.paused = True
        self._steps += 1

    def take(self) -> bool:
        """Return whether the next tick is allowed now, and use up a step that allows it."""
        if self.waiting:
            return False
        if self.paused:
            self._steps -= 1
        return True
