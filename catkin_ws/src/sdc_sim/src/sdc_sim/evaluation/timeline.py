"""Classification of odometry stamps: next tick, implausible stamp, restarted simulation."""

from __future__ import annotations

import math

NEXT, IGNORED, RESTARTED = "next", "ignored", "restarted"

# Time may jump farther ahead than this, or back, only if this many stamps in a row agree:
# a single bad message is not a jump.
_MAX_STEP_S = 10.0
_AGREEING_STAMPS = 5
# The stamps of two publishers can differ a little; a restarted simulation is farther back.
_RESTART_S = 1.0


class Timeline:
    """The simulated time of a drive, advanced by one stamp after the other."""

    def __init__(self):
        self.now_s: float | None = None
        self._jump_s: float | None = None
        self._agreeing = 0

    def advance(self, time_s: float) -> str:
        """Return how a stamp [s] continues the drive, and advance `now_s` accordingly.

        Returns:
            NEXT: time advanced; IGNORED: a repeated or implausible stamp; RESTARTED: time begins
            again with this stamp
        """
        if not math.isfinite(time_s):
            return IGNORED
        if self.now_s is None or 0.0 < time_s - self.now_s <= _MAX_STEP_S:
            self._jump_s = None
            self.now_s = time_s
            return NEXT
        if time_s == self.now_s:
            return IGNORED
        agrees = self._jump_s is not None and 0.0 < time_s - self._jump_s <= _MAX_STEP_S
        self._agreeing = self._agreeing + 1 if agrees else 1
        self._jump_s = time_s
        jump_s = time_s - self.now_s
        if self._agreeing < _AGREEING_STAMPS or -_RESTART_S <= jump_s < 0.0:
            return IGNORED
        self._jump_s = None
        self.now_s = time_s
        return NEXT if jump_s > 0.0 else RESTARTED
