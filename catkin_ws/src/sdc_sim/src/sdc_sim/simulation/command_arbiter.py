"""Arbitration between several publishers of control commands."""

from __future__ import annotations


class CommandArbiter:
    """Accepts commands of one publisher at a time: a car that obeys two jerks between them.

    The first publisher keeps control until it has sent no command for timeout_ticks. Then the next
    one that sends a command gets control.
    """

    def __init__(self, timeout_ticks: int):
        self._timeout_ticks = timeout_ticks
        self._last_tick = 0
        self.active: str | None = None

    def admits(self, name: str, tick: int) -> bool:
        """Return whether to accept a command that this publisher sends in this tick."""
        if self.active not in (None, name) and tick - self._last_tick <= self._timeout_ticks:
            return False
        self.active = name
        self._last_tick = tick
        return True

    def release(self) -> None:
        """Accept the next command of any publisher."""
        self.active = None
