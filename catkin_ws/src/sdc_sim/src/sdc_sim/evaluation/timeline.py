"""Which stamps are the next moment of a drive, and which mean that the world was started anew."""

from __future__ import annotations

import math

NEXT, LEFT_OUT, RESTARTED = "next", "left_out", "restarted"

# Time that leaps this far ahead, or back at all, is believed when so many stamps in a row agree on it: one bad message is no leap.
_LONGEST_GAP_S = 10.0
_AGREEING = 5
# Two publishers' stamps may lie a little apart; a world that was started anew is farther back.
_RESTART_S = 1.0


class Timeline:
    """Judges one stamp after the other."""

    def __init__(self):
        self.now_s = None
        self._leap_s = None
        self._agreeing = 0

    def take(self, time_s: float) -> str:
        """NEXT: time moved on. LEFT_OUT: a repeated or a strange stamp. RESTARTED: time begins anew with this stamp."""
        if not math.isfinite(time_s):
            return LEFT_OUT
        if self.now_s is None or 0.0 < time_s - self.now_s <= _LONGEST_GAP_S:
            self._leap_s = None
            self.now_s = time_s
            return NEXT
        if time_s == self.now_s:
            return LEFT_OUT
        agrees = self._leap_s is not None and 0.0 < time_s - self._leap_s <= _LONGEST_GAP_S
        self._agreeing = self._agreeing + 1 if agrees else 1
        self._leap_s = time_s
        leap_s = time_s - self.now_s
        if self._agreeing < _AGREEING or -_RESTART_S <= leap_s < 0.0:
            return LEFT_OUT
        self._leap_s = None
        self.now_s = time_s
        return NEXT if leap_s > 0.0 else RESTARTED
