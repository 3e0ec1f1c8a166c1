"""The progress of a sweep: a line that updates in place, or some plain lines in a log."""

from __future__ import annotations

import time
from typing import TextIO

_TERMINAL_PERIOD_S = 0.2
_LOG_PERIOD_S = 10.0


class SweepProgress:
    """Prints how many cells are done.

    Args:
        stream: where to print
        total: number of all cells
        done: number of the cells that an earlier sweep has driven
        name: of the command
    """

    def __init__(self, stream: TextIO, total: int, done: int, name: str = "sweep"):
        self._stream, self._total, self._name = stream, total, name
        self._in_place = stream.isatty()
        self._first = self._done = done
        self._failed = 0
        self._start_s, self._next_s = time.monotonic(), 0.0

    def add(self, failed: bool) -> None:
        """Count a cell, and print what is due."""
        self._done += 1
        self._failed += failed
        now_s = time.monotonic()
        if now_s < self._next_s and self._done < self._total:
            return
        self._next_s = now_s + (_TERMINAL_PERIOD_S if self._in_place else _LOG_PERIOD_S)
        rate = (self._done - self._first) / max(now_s - self._start_s, 1e-3)
        left_s = round((self._total - self._done) / rate)
        failures = f", {self._failed} failed" if self._failed else ""
        line = f"{self._name}: {self._done} of {self._total}{failures}, {rate:.1f} drives/s, "
        line += f"{left_s // 60}:{left_s % 60:02d} left"
        self._stream.write(f"\r\x1b[K{line}" if self._in_place else f"{line}\n")
        self._stream.flush()

    def close(self) -> None:
        """End the line."""
        if self._in_place and self._done > self._first:
            self._stream.write("\n")
