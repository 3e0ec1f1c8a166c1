"""Who sits at the wheel when more than one node commands the car."""

from __future__ import annotations


class CommandArbiter:
    """The node that commanded first keeps the seat until it has been silent for `patience_ticks`; then the next one has it.

    A car that obeyed two at once would jerk between them.
    """

    def __init__(self, patience_ticks: int):
        self._patience_ticks = patience_ticks
        self._heard_at = 0
        self.driver = None

    def admits(self, name: str, tick: int) -> bool:
        """Whether the car obeys a command of this node that comes in this tick."""
        if self.driver not in (None, name) and tick - self._heard_at <= self._patience_ticks:
            return False
        self.driver = name
        self._heard_at = tick
        return True

    def leave(self) -> None:
        """The driver has not answered: the seat is free at once."""
        self.driver = None
