"""The commands of a drive, and which odometry each of them answers."""

from __future__ import annotations

import math
from bisect import bisect_right

import numpy as np

COMMAND_FIELDS = ("throttle", "brake", "steer")
_NO_COMMAND = (math.nan, math.nan, math.nan)


class CommandTrace:
    """The ticks and commands of a drive, in the order in which they arrived.

    A command answers the odometry with its stamp. Another one, as of a stack without stamps,
    answers by order: the last odometry or, because messages arrive on several connections in any
    order, the one before it, if that has no command yet.
    """

    def __init__(self):
        self.stamps: list[int] = []  # the stamps of the ticks [ns]
        self._commands: list = []
        self._command_stamps: list[int] = []
        self._ticks_before: list[int] = []

    def add_command(self, stamp: int, throttle: float, brake: float, steer: float) -> None:
        """Add a command."""
        self._commands.append((throttle, brake, steer))
        self._command_stamps.append(stamp)
        self._ticks_before.append(len(self.stamps))

    def counts(self) -> dict[str, int]:
        """Return the report's numbers of ticks by the commands that answered them.

        The command of the last tick can still arrive: this tick is not missed.
        """
        answered, ticks = set(self._command_stamps), set(self.stamps)
        open_ticks = [stamp not in answered for stamp in self.stamps]
        missed, by_stamp, by_order = sum(open_ticks[:-1]), len(ticks & answered), 0
        for stamp, before in zip(self._command_stamps, self._ticks_before):
            for tick in range(max(before - 2, 0), before if stamp not in ticks else 0):
                if open_ticks[tick]:
                    open_ticks[tick] = False
                    by_order += 1
                    break
        return {"missed_ticks": missed, "ticks_by_stamp": by_stamp, "ticks_by_order": by_order}

    def as_array(self, ticks: int) -> np.ndarray:
        """Return throttle, brake and steer of the first ticks: (ticks, 3), NaN if unknown.

        The command of a tick is the first with its stamp, else the last that was received in it or
        in a tick before it.
        """
        first = {stamp: place for place, stamp in reversed([*enumerate(self._command_stamps)])}
        early = bisect_right(self._ticks_before, 0)
        places = []
        for tick, stamp in enumerate(self.stamps[:ticks]):
            received = bisect_right(self._ticks_before, tick + 1) - 1
            places.append(first.get(stamp, received if received >= early else -1))
        return np.array([*self._commands, _NO_COMMAND])[places].reshape(-1, 3)
