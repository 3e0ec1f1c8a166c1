"""Status of a drive on the console: one line that updates in place, or plain lines in a log."""

from __future__ import annotations

import shutil
from collections import deque
from typing import TextIO

from sdc_sim.evaluation.drive_evaluation import DriveEvaluation
from sdc_sim.evaluation.evaluator import Evaluator

# Periods on the wall clock: of the status line in a terminal, and of all others.
_TERMINAL_PERIOD_S = 0.25
_LOG_PERIOD_S = 5.0
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
        waits = drive is None or not evaluator.started
        if self._next_s is None:
            self._next_s = wall_s + (_LOG_PERIOD_S if waits else 0.0)
        if wall_s < self._next_s:
            return
        period_s = _TERMINAL_PERIOD_S if self._in_place and not waits else _LOG_PERIOD_S
        self._next_s = wall_s + period_s
        if drive is None or waits:
            self.print_line(f"referee: waiting for {' and '.join(evaluator.missing_topics)}")
            return
        self._marks.append((wall_s, drive.progress.samples[-1].time_s))
        (first_wall_s, first_s), (_, time_s) = self._marks[0], self._marks[-1]
        line = progress_line(drive)
        if wall_s > first_wall_s:
            line += f" {(time_s - first_s) / (wall_s - first_wall_s):.1f}x real time"
        if self._in_place:
            # The cursor returns to the start, so that output of other nodes overwrites the line.
            line = line[: max(shutil.get_terminal_size().columns - 1, 20)]
            self._write(f"\r\x1b[K{line}\r")
            self._status_shown = True
        else:
            self._write(line + "\n")

    def print_line(self, line: str) -> None:
        """Print a line that stays."""
        self._write(("\r\x1b[K" if self._status_shown else "") + line + "\n")
        self._status_shown = False

    def _write(self, text: str) -> None:
        try:
            self._stream.write(text)
            self._stream.flush()
        except (OSError, ValueError):
            pass


def progress_line(drive: DriveEvaluation) -> str:
    """Return the status line, without the pace."""
    progress, last = drive.progress, drive.progress.samples[-1]
    minutes, seconds = divmod(int(round(drive.time_left_s())), 60)
    return (
        f"referee: {progress.completion_percent:4.1f} % {last.speed_mps:4.1f} m/s  "
        f"cross-track error {last.cross_track_m:+.2f} m  {minutes:d}:{seconds:02d} left"
    )


def closing_line(metrics: dict, node: str = "referee") -> str:
    """Return the line that sums up a drive, by the name of the node that evaluates it."""
    factor = metrics["real_time_factor"]
    pace = "" if factor is None else f" ({factor:.1f} times real time)"
    return (
        f"{node}: {metrics['status']}: {metrics['route_completion_percent']:.1f} % of "
        f"{metrics['route_length_m']:.0f} m in {metrics['duration_s']:.1f} s{pace}, "
        f"cross-track error {metrics['cross_track_rms_m']:.3f} m RMS, "
        f"{metrics['cross_track_max_m']:.3f} m at worst; "
        f"driving score {metrics['driving_score']:.0f}"
    )
