"""The period of a stack that sends its commands at a rate of its own."""

from __future__ import annotations

_AGREEING_GAPS = 5
_STEADY_ANSWERS = 10
_STEADY_FACTOR = 40.0


class CommandPeriod:
    """Learns that commands arrive in every second tick only, or in every n-th.

    A loop at 10 Hz of simulated time sends nothing in every second tick of 20 Hz: waiting there
    is useless. A period counts after some equal gaps between commands. A command before its time
    shortens it. When a due command does not arrive, the period is 1 again, and twice as many gaps
    must agree: that stack does not follow the simulated time.

    Attributes:
        ticks: ticks from one command to the next; 1 until a longer period is learned
    """

    def __init__(self) -> None:
        self.ticks = 1
        self._gap = 0
        self._last_gap = 0
        self._agreeing = 0
        self._needed = _AGREEING_GAPS
        self._answers = 0

    @property
    def is_due(self) -> bool:
        """Whether a command can be expected in this tick."""
        return self._gap + 1 >= self.ticks

    @property
    def patience_factor(self) -> float:
        """How much longer than usual to wait in this tick; 0 when no command is due.

        A stack that sent its last commands in time sends this one, too: a busy machine is slow.
        """
        if not self.is_due:
            return 0.0
        return _STEADY_FACTOR if self._answers >= _STEADY_ANSWERS else 1.0

    def end_tick(self, received: bool) -> None:
        """Record whether a command was received in this tick."""
        if received:
            self._answers += 1
        elif self.is_due:
            self._answers = 0
        self._gap += 1
        if received:
            self._agreeing = self._agreeing + 1 if self._gap == self._last_gap else 1
            if self._gap < self.ticks or self._agreeing >= self._needed:
                self.ticks = self._gap
            self._last_gap, self._gap = self._gap, 0
        elif self._gap >= self.ticks > 1:
            self.ticks, self._agreeing = 1, 0
            self._needed *= 2
