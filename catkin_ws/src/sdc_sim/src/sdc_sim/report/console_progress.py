"""Status of a drive on the console: one line that updates in place, or plain lines in a log."""

from __future__ import annotations

import shutil
from collections import deque
from typing import TextIO

from sdc_sim.evaluation.evaluator import Evaluator

# Periods of the status line on the wall clock.
_TERMINAL_PERIOD_S = 0.25
_LOG_PERIOD_S = 5.0
_WAITING_PERIOD_S = 5.0
_PACE_LINES = 8


class ConsoleProgress:
    """The status of an evaluator, written to a stream.

    A stream that accepts no data, such as a closed terminal or a full disk, does not end the drive.
    """

    def __init__(self, stream: TextIO):
        self._stream = stream
        self._in_place = stream.isatty()
        self._next_s: float | None = None
        self._status_shown = False
        self._marks: deque = deque(maxlen=_PACE_LINES)

    def update(self, evaluator: Evaluator, wall_s: float) -> None:
        """Print what is due at this time on the wall clock [s]."""
        drive = evaluator.drive
        if drive is None or not evaluator.started:
            if self._next_s is None:
                self._next_s = wall_s + _WAITING_PERIOD_S
            elif wall_s >= self._next_s:
                self._next_s = wall_s + _WAITING_PERIOD_S
                self.print_line(f"referee: waiting for {' and '.join(evaluator.missing_topics)}")
        elif self._next_s is None or wall_s >= self._next_s:
            self._next_s = wall_s + (_TERMINAL_PERIOD_S if self._in_place else _LOG_PERIOD_S)
            last = drive.progress.samples[-1]
            self._print_status(
                progress_line(
                    drive.progress.completion_percent,
                    last.speed_mps,
                    last.cross_track_m,
                    drive.time_left_s(),
                    self._pace(wall_s, last.time_s),
                )
            )

    def print_line(self, line: str) -> None:
        """Print a line that stays."""
        self._write(("\r\x1b[K" if self._status_shown else "") + line + "\n")
        self._status_shown = False

    def _pace(self, wall_s: float, time_s: float) -> float | None:
        """Return the real-time factor over the last status lines, or None if it is unknown."""
        self._marks.append((wall_s, time_s))
        first_wall_s, first_s = self._marks[0]
        return (time_s - first_s) / (wall_s - first_wall_s) if wall_s > first_wall_s else None

    def _print_status(self, line: str) -> None:
        if self._in_place:
            # The cursor returns to the start, so that output of other nodes overwrites the line.
            line = line[: max(shutil.get_terminal_size().columns - 1, 20)]
            self._write(f"\r\x1b[K{line}\r")
            self._status_shown = True
        else:
            self._write(line + "\n")

    def _write(self, text: str) -> None:
        try:
            self._stream.write(text)
            self._stream.flush()
        except (OSError, ValueError):
            pass


def progress_line(
    percent: float,
    speed_mps: float,
    cross_track_m: float,
    left_s: float,
    real_time_factor: float | None,
) -> str:
    """Return the status line.

    Args:
        percent: completed share of the route [%]
        speed_mps: speed of the car [m/s]
        cross_track_m: cross-track error, positive to the left [m]
        left_s: estimated simulated time to the end of the route [s]
        real_time_factor: simulated time over wall time, None if unknown
    """
    factor = "" if real_time_factor is None else f" {real_time_factor:.1f}x real time"
    minutes, seconds = divmod(int(round(left_s)), 60)
    return (
        f"referee: {percent:4.1f} % {speed_mps:4.1f} m/s  cross-track error {cross_track_m:+.2f} m"
        f"  {minutes:d}:{seconds:02d} left{factor}"
    )


def closing_line(metrics: dict) -> str:
    """Return the line that sums up a drive."""
    factor = metrics["real_time_factor"]
    pace = "" if factor is None else f" ({factor:.1f} times real time)"
    return (
        f"referee: {metrics['status']}: {metrics['route_completion_percent']:.1f} % of "
        f"{metrics['route_length_m']:.0f} m in {metrics['duration_s']:.1f} s{pace}, "
        f"cross-track error {metrics['cross_track_rms_m']:.3f} m RMS, "
        f"{metrics['cross_track_max_m']:.3f} m at worst; "
        f"driving score {metrics['driving_score']:.0f}"
    )
