"""The progress of long work: a line that updates in place, or some plain lines in a log."""

from __future__ import annotations

import time
from typing import TextIO

_TERMINAL_PERIOD_S = 0.2
_LOG_PERIOD_S = 10.0


class SweepProgress:
    """Prints how many of a number of things, such as pages, a command has done, from the start."""

    def __init__(
        self, stream: TextIO, total: int, done: int, name: str = "sweep", things: str = "drives"
    ):
        self._stream, self._total, self._name, self._things = stream, total, name, things
        self._in_place = stream.isatty()
        self._first = self._done = done
        self._failed = 0
        self._start_s, self._next_s = time.monotonic(), 0.0
        if done < total:
            self._print("")

    def add(self, failed: bool = False) -> None:
        """Count a thing that is done, and print what is due."""
        self._done += 1
        self._failed += failed
        now_s = time.monotonic()
        if now_s < self._next_s and self._done < self._total:
            return
        self._next_s = now_s + (_TERMINAL_PERIOD_S if self._in_place else _LOG_PERIOD_S)
        rate = (self._done - self._first) / max(now_s - self._start_s, 1e-3)
        left_s = round((self._total - self._done) / rate)
        failures = f", {self._failed} failed" if self._failed else ""
        left = f", {left_s // 60}:{left_s % 60:02d} left" if self._done < self._total else ""
        self._print(f"{failures}, {rate:.1f} {self._things}/s{left}")

    def _print(self, details: str) -> None:
        line = f"{self._name}: {self._done} of {self._total} {self._things}{details}"
        self._stream.write(f"\r\x1b[K{line}" if self._in_place else f"{line}\n")
        self._stream.flush()

    def close(self) -> None:
        """End the line."""
        if self._in_place and self._total > self._first:
            self._stream.write("\n")
