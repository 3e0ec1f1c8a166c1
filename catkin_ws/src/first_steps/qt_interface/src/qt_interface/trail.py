"""The trail behind the car, in pieces, so that a frame draws only the newest piece again."""

from __future__ import annotations

import math

PIECE_LENGTH = 125  # points; a trail of 10,000 has 80 pieces, enough to fade without visible steps


class Trail:
    """The last positions of the car.

    `finished` pieces, oldest first, never change; `growing` is the newest piece. A piece begins at
    the end of the previous one, unless the car was moved by hand. `version` changes together with
    `finished`.
    """

    def __init__(self, limit: int, jump: float):
        """Create an empty trail.

        Args:
            limit: largest number of positions; the oldest piece is removed as a whole
            jump: a longer step [u] is not part of the motion and interrupts the line
        """
        self.limit = limit
        self.jump = jump
        self.version = 0
        self.clear()

    def __len__(self) -> int:
        """Return the number of stored positions."""
        return sum(len(piece) for piece in self.finished) + len(self.growing)

    def clear(self) -> None:
        """Remove all positions."""
        self.finished: list[list[tuple[float, float]]] = []
        self.growing: list[tuple[float, float]] = []
        self.version += 1

    def add(self, x: float, y: float) -> None:
        """Add a position of the car [u]."""
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

    def _finish(self, beginning: list[tuple[float, float]]) -> None:
        self.finished.append(self.growing)
        self.growing = list(beginning)
        self.version += 1
