"""The progress bar of a sweep: a line that updates in place, or some plain lines in a log."""

from __future__ import annotations

import shutil
import time
from typing import TextIO

_TERMINAL_PERIOD_S = 0.2
_LOG_PERIOD_S = 10.0
_BAR = 30


class SweepProgress:
    """Prints how many cells are done.

    Args:
        stream: where to print
        total: number of all cells
        done: number of the cells that an earlier sweep has driven
        name: of the command, before the bar
    """

    def __init__(self, stream: TextIO, total: int, done: int, name: str = "sweep"):
        self._stream = stream
        self._in_place = stream.isatty()
        self._total = total
        self._first = self._done = done
        self._failed = 0
        self._name = name
        self._start_s = time.monotonic()
        self._next_s = 0.0

    def add(self, failed: bool) -> None:
        """Count a cell, and print what is due."""
        self._done += 1
        self._failed += failed
        now_s = time.monotonic()
        if now_s >= self._next_s or self._done == self._total:
            self._next_s = now_s + (_TERMINAL_PERIOD_S if self._in_place else _LOG_PERIOD_S)
            self._print(now_s - self._start_s)

    def close(self) -> None:
        """End the line."""
        if self._in_place and self._done > self._first:
            self._stream.write("\n")

    def _print(self, wall_s: float) -> None:
        filled = _BAR * self._done // max(self._total, 1)
        rate = (self._done - self._first) / max(wall_s, 1e-3)
        left_s = round((self._total - self._done) / rate)
        failed = f", {self._failed} failed" if self._failed else ""
        line = (
            f"{self._name}: [{'#' * filled}{'.' * (_BAR - filled)}] "
            f"{self._done} of {self._total}{failed}, "
            f"{rate:.1f} drives/s, {left_s // 60}:{left_s % 60:02d} left"
        )
        if self._in_place:
            line = line[: max(shutil.get_terminal_size().columns - 1, 20)]
            self._stream.write(f"\r\x1b[K{line}")
        else:
            self._stream.write(line + "\n")
        self._stream.flush()
