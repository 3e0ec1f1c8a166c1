"""Matching of commands with the observation that they answer, for lockstep."""

from __future__ import annotations

from typing import Tuple

# Seconds and nanoseconds of simulated time.
Stamp = Tuple[int, int]
UNSTAMPED: Stamp = (0, 0)
# After this many single ticks without a command, stamps are those of a loop with its own rate.
_MAX_GAPS = 3


class AnswerTracker:
    """Decides whether the last observation has an answer: by stamp or by order.

    By stamp: a command with the stamp of the observation answers it. This holds from the first
    command on that has the stamp of any observation of this simulation.

    By order: the first command after the observation answers it. This holds while no command has
    such a stamp. A later stamp, as of another simulation or of the wall clock, may be left from
    before the start; it answers nothing until a tick has ended without an answer.

    Some nodes stamp commands with the time at which they send them. Such a stamp is one tick late
    or is missing in some ticks. When a tick has therefore ended without an answer, order decides
    for the rest of the drive.

    Attributes:
        stamped: whether the last command had a stamp
        by_stamp: whether stamps decide
    """

    def __init__(self) -> None:
        self.stamped = False
        self.by_stamp = False
        self._answered = UNSTAMPED
        self._late_at = UNSTAMPED  # the last observation at which a command had an older stamp
        self._given_up = UNSTAMPED  # the last observation without an answer
        self._gaps = 0
        self._stamps_ignored = False

    def is_repeated(self, stamp: Stamp, observed: Stamp) -> bool:
        """Return whether a command with this stamp answers an observation that has an answer."""
        repeated = self.by_stamp and stamp != UNSTAMPED and stamp <= self._answered
        if repeated and stamp < observed:
            self._late_at = observed
        return repeated

    def record(self, stamp: Stamp, observed: Stamp) -> None:
        """Record a command with this stamp while the observation `observed` is the last one."""
        self.stamped = stamp != UNSTAMPED
        if not UNSTAMPED < stamp <= observed:
            return
        self.by_stamp = not self._stamps_ignored
        if stamp == observed:
            self._answered = stamp
        else:
            self._late_at = observed

    def give_up(self, observed: Stamp) -> None:
        """Record that the next tick starts without an answer to this observation."""
        if self.by_stamp and self._answered > self._given_up:
            self._gaps += 1  # of consecutive ticks, only the first one counts
        if self.by_stamp and (self._late_at == observed or self._gaps >= _MAX_GAPS):
            self.by_stamp, self._stamps_ignored = False, True
        self._given_up = observed

    def has_answer(self, observed: Stamp, received: bool) -> bool:
        """Return whether a command has answered this observation.

        Args:
            observed: stamp of the last observation
            received: whether a command was accepted after it
        """
        if self._answered == observed:
            return True
        valid = not self.stamped or self._given_up != UNSTAMPED
        return received and not self.by_stamp and valid
