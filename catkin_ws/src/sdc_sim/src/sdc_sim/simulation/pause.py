"""Pause, resume, step: whether the world may take its next tick."""

from __future__ import annotations


class PauseControl:
    """Runs, stands, or stands with some steps to go."""

    def __init__(self):
        self.paused = False
        self._steps = 0

    @property
    def waiting(self) -> bool:
        """Whether the world stands still until somebody says otherwise."""
        return self.paused and self._steps == 0

    def pause(self) -> None:
        """Stand after the present tick."""
        self.paused = True
        self._steps = 0

    def resume(self) -> None:
        """Run."""
        self.paused = False
        self._steps = 0

    def step(self) -> None:
        """One tick more, then stand: a running world pauses after it."""
        self.paused = True
        self._steps += 1

    def memory(self) -> list:
        """How it stands, as plain data."""
        return [self.paused, self._steps]

    def recall(self, paused: bool, steps: int) -> None:
        """Stand as `memory` said."""
        self.paused, self._steps = paused, steps

    def take(self) -> bool:
        """Ask for a tick: whether it may be taken. A granted step is used up."""
        if self.waiting:
            return False
        if self.paused:
            self._steps -= 1
        return True
