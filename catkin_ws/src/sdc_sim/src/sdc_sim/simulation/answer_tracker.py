"""Matching of commands with the observation that they answer, for lockstep."""

from __future__ import annotations

from typing import Tuple

# Seconds and nanoseconds of simulated time.
Stamp = Tuple[int, int]
UNSTAMPED: Stamp = (0, 0)


class AnswerTracker:
    """Decides whether the last observation has an answer.

    A command with a stamp answers the observation with this stamp. A command without a stamp
    answers the last observation. When a tick has ended without an answer although a command with
    another stamp has arrived, as one of the wall clock, stamps are ignored from then on.

    Attributes:
        answered: whether a command has answered the last observation
        by_stamp: whether the last command had a stamp that is not ignored
    """

    def __init__(self) -> None:
        self.answered = False
        self.by_stamp = False
        self._ignores_stamps = False
        self._other_stamp = False
        self._last_answered = UNSTAMPED

    def expect(self) -> None:
        """Expect the answer to a new observation."""
        self.answered = self._other_stamp = False

    def is_repeated(self, stamp: Stamp, observed: Stamp) -> bool:
        """Return whether a command with this stamp answers an observation that has an answer."""
        repeated = not self._ignores_stamps and UNSTAMPED < stamp <= self._last_answered
        if repeated and stamp < observed:
            self._other_stamp = True
        return repeated

    def record(self, stamp: Stamp, observed: Stamp) -> None:
        """Record a command with this stamp while the observation `observed` is the last one."""
        self.by_stamp = stamp != UNSTAMPED and not self._ignores_stamps
        if not self.by_stamp:
            self.answered = True
        elif stamp == observed:
            self.answered, self._last_answered = True, stamp
        else:
            self._other_stamp = True

    def give_up(self) -> None:
        """Record that the next tick starts without an answer to the last observation."""
        if self._other_stamp:
            self._ignores_stamps, self.by_stamp = True, False
