"""Counts the ticks of a drive and those that no command answered."""

from __future__ import annotations

from collections import OrderedDict

# A command may be heard after the next odometry: a tick counts as missed when this many later ones have been heard.
_PATIENCE = 1000


class CommandMatching:
    """Pairs the stamps of odometry messages with the stamps of commands, in whichever order they are heard."""

    def __init__(self):
        self.asked = 0
        self.answered = 0
        self._lost = 0
        self._open = OrderedDict()
        self._early = OrderedDict()
        self._last = None

    def ask(self, stamp: int) -> bool:
        """An odometry with this stamp was heard; returns False for the stamp heard last, which is no new tick."""
        if stamp == self._last:
            return False
        self._last = stamp
        self.asked += 1
        if self._early.pop(stamp, None) is None:
            self._open[stamp] = True
        else:
            self.answered += 1
        if len(self._open) > _PATIENCE:
            self._open.popitem(last=False)
            self._lost += 1
        return True

    def answer(self, stamp: int) -> None:
        """A command with this stamp was heard."""
        if self._open.pop(stamp, None) is not None:
            self.answered += 1
        elif stamp != self._last:
            self._early[stamp] = True
            if len(self._early) > _PATIENCE:
                self._early.popitem(last=False)

    @property
    def awaited(self) -> bool:
        """Whether ticks are answered at all, and the answer to some tick, the last one included, has not been heard."""
        return self.answered > 0 and bool(self._open)

    @property
    def missed(self) -> int:
        """Ticks without an answer; the last tick does not count, its answer may be on the way."""
        return self._lost + sum(1 for stamp in self._open if stamp != self._last)
