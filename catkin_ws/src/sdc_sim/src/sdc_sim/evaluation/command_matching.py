"""Matching of commands to odometry messages by their stamps."""

from __future__ import annotations

import math
from collections import OrderedDict
from itertools import chain

import numpy as np

COMMAND_FIELDS = ("throttle", "brake", "steer")
# A command can arrive after later odometry. Of more open ticks than this, the oldest is missed.
_MAX_OPEN = 1000
# So many odometry messages wait for a command without their stamp.
_MAX_LATE = 2
_UNSTAMPED = 0
_NO_COMMAND = (math.nan, math.nan, math.nan)


class CommandMatching:
    """Counters of the odometry messages of a drive and of how commands answered them.

    A command answers the odometry with its stamp. Another one, as of a stack without stamps,
    answers by order: the last odometry or, because messages arrive on several connections in any
    order, the one before it, if that has no command yet.

    Attributes:
        ticks: odometry messages
        answered: those answered by stamp
        last_stamp: stamp of the last odometry [ns], None before it
    """

    def __init__(self):
        self.ticks = 0
        self.answered = 0
        self._by_order = 0
        self._lost = 0
        self._without_command = 0
        self._open: OrderedDict[int, bool] = OrderedDict()
        self._early: OrderedDict[int, bool] = OrderedDict()  # True: counted in by_order
        self.last_stamp: int | None = None

    def add_odometry(self, stamp: int) -> None:
        """Count the odometry with this stamp; a repeated stamp does not count."""
        if stamp == self.last_stamp:
            return
        self.last_stamp = stamp
        self.ticks += 1
        by_order = self._early.pop(stamp, None)
        if by_order is None:
            self._open[stamp] = True
            self._without_command = min(self._without_command + 1, _MAX_LATE)
        else:
            self.answered += 1
            self._by_order -= by_order
        if len(self._open) > _MAX_OPEN:
            self._open.popitem(last=False)
            self._lost += 1

    def add_command(self, stamp: int) -> None:
        """Match a command with this stamp to its odometry."""
        answers = self._without_command > 0
        if self._open.pop(stamp, None) is not None:
            self.answered += 1
            self._without_command -= answers
        elif stamp != self.last_stamp:
            self._by_order += answers
            self._without_command -= answers
            self._early[stamp] = answers and stamp != _UNSTAMPED
            if len(self._early) > _MAX_OPEN:
                self._early.popitem(last=False)

    @property
    def by_order(self) -> int:
        """Return the number of odometry messages that a command without their stamp answered."""
        return min(self._by_order, self.ticks - self.answered)

    @property
    def pending(self) -> bool:
        """Return whether the last command is missing in a drive whose commands carry stamps."""
        return self.answered > 0 and self.last_stamp in self._open

    @property
    def missed(self) -> int:
        """Return the number of ticks without a command; that of the last tick can still arrive."""
        return self._lost + sum(1 for stamp in self._open if stamp != self.last_stamp)


class CommandTrace:
    """The command of each tick: the first with the stamp of the tick, else the last received.

    Attributes:
        stamps: the stamps of the ticks [ns]
    """

    def __init__(self):
        self.stamps: list = []
        self._received: list = []
        self._by_stamp: dict = {}

    def add_odometry(self, stamp: int) -> None:
        """Begin a tick."""
        self.stamps.append(stamp)
        self._received.append(self._received[-1] if self._received else _NO_COMMAND)

    def add_command(self, stamp: int, throttle: float, brake: float, steer: float) -> None:
        """Add a command, which belongs to the tick with its stamp or else to the current one."""
        command = throttle, brake, steer
        self._by_stamp.setdefault(stamp, command)
        if self._received:
            self._received[-1] = command

    def as_array(self, ticks: int) -> np.ndarray:
        """Return throttle, brake and steer of the first ticks: (ticks, 3), NaN if unknown."""
        rows = [
            self._by_stamp.get(stamp, received)
            for stamp, received in zip(self.stamps[:ticks], self._received)
        ]
        return np.fromiter(chain.from_iterable(rows), float).reshape(-1, 3)
