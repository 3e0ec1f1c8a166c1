"""The order of odometry stamps: a drive advances, and a single bad stamp does not end it."""

from __future__ import annotations

import math

# Time may jump farther ahead than this only if so many stamps in a row agree.
_MAX_STEP_S = 10.0
_AGREEING_STAMPS = 5


class StampFilter:
    """Accepts the stamps that advance a drive.

    Attributes:
        last_s: the last accepted stamp [s], None before the first one
    """

    def __init__(self):
        self.last_s: float | None = None
        self._jump_s: float | None = None
        self._agreeing = 0

    def accepts(self, time_s: float) -> bool:
        """Return whether this stamp [s] advances the drive; it is then the last one."""
        if not math.isfinite(time_s) or (self.last_s is not None and time_s <= self.last_s):
            return False
        if self.last_s is not None and time_s - self.last_s > _MAX_STEP_S:
            agrees = self._jump_s is not None and 0.0 < time_s - self._jump_s <= _MAX_STEP_S
            self._agreeing = self._agreeing + 1 if agrees else 1
            self._jump_s = time_s
            if self._agreeing < _AGREEING_STAMPS:
                return False
        self._jump_s = None
        self.last_s = time_s
        return True
