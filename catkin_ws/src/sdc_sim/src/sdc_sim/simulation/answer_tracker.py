"""Matching of commands with the observation that they answer, for lockstep."""

from __future__ import annotations

from typing import Tuple

# Seconds and nanoseconds of simulated time.
Stamp = Tuple[int, int]
UNSTAMPED: Stamp = (0, 0)


class AnswerTracker:
    """Records which observations commands have answered: those with the same stamp."""

    def __init__(self) -> None:
        self.stamped = False  # whether the last command had a stamp
        self._answered = UNSTAMPED

    def is_repeated(self, stamp: Stamp) -> bool:
        """Return whether a command with this stamp answers an observation that has an answer."""
        return stamp != UNSTAMPED and stamp <= self._answered

    def record(self, stamp: Stamp, observed: Stamp) -> None:
        """Record a command with this stamp while the observation `observed` is the last one.

        A stamp that differs answers nothing. A later one may be left from another simulation.
        """
        self.stamped = stamp != UNSTAMPED
        if stamp == observed:
            self._answered = stamp

    def has_answer(self, observed: Stamp) -> bool:
        """Return whether a command has answered this observation."""
        return self._answered == observed

    def checkpoint(self) -> list:
        """Return the state as plain data."""
        return [self.stamped, self._answered]

    def restore(self, stamped: bool, answered: list) -> None:
        """Restore a checkpoint."""
        self.stamped, self._answered = stamped, (answered[0], answered[1])
