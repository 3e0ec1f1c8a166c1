"""The trail behind the car, cut into pieces so that a long one need not be drawn anew for each frame."""

from __future__ import annotations

import math

PIECE_LENGTH = 125  # points; 80 pieces make a trail of 10,000, so its fading shows no steps


class Trail:
    """The last `limit` positions of the car, or up to a piece fewer: the oldest piece goes as a whole.

    `finished` pieces, oldest first, never change; `growing` is the piece that the car adds to. A piece begins where
    the one before it ended, unless the car was carried. `version` changes when `finished` does.
    """

    def __init__(self, limit, jump):
        self.limit = limit
        self.jump = jump
        self.version = 0
        self.clear()

    def __len__(self):
        """How many positions are remembered."""
        return sum(len(piece) for piece in self.finished) + len(self.growing)

    def clear(self):
        """Forgets all positions."""
        self.finished = []
        self.growing = []
        self.version += 1

    def add(self, x, y):
        """Adds the car's position in field units; one farther than `jump` from the last one begins a new line."""
        if self.growing:
            last_x, last_y = self.growing[-1]
            if (x, y) == (last_x, last_y):
                return
            if math.hypot(x - last_x, y - last_y) > self.jump:
                self._finish([])
            elif len(self.growing) >= min(PIECE_LENGTH, self.limit):
                self._finish(self.growing[-1:])
        self.growing.append((x, y))
        while self.finished and len(self) > self.limit:
            self.finished.pop(0)
            self.version += 1

    def _finish(self, beginning):
        self.finished.append(self.growing)
        self.growing = list(beginning)
        self.version += 1
