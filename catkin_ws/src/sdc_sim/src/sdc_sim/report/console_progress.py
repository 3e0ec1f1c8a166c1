"""Tells a person how the drive goes: one line that stays in its place in a terminal, plain lines in a log."""

from __future__ import annotations

import shutil

# How often, in seconds of the wall clock.
_TERMINAL_S = 0.25
_LOG_S = 5.0
_PATIENCE_S = 5.0
_RECENT_S = 2.0


class ConsoleProgress:
    """Looks at a Watch and writes to a stream. A stream that takes nothing any more (a closed terminal, a full disk) never ends
    the drive. Time is that of the wall clock, given with each call."""

    def __init__(self, stream):
        self._stream = stream
        self._in_place = stream.isatty()
        self._next_s = None
        self._standing = False
        self._marks = []
        self._told = set()

    def update(self, watch, wall_s: float) -> None:
        """Tell what there is to tell by now."""
        self.tell_news(watch)
        if watch.missing:
            self._say_missing(watch.missing, wall_s)
        elif self._next_s is None or wall_s >= self._next_s:
            self._next_s = wall_s + (_TERMINAL_S if self._in_place else _LOG_S)
            last = watch.drive.samples[-1]
            self.show(
                progress_line(
                    watch.drive.completion_percent,
                    last.speed_mps,
                    last.cross_track_m,
                    watch.time_left_s(),
                    self._pace(wall_s, last.time_s),
                )
            )

    def tell_news(self, watch) -> None:
        """Say once what a person should know of."""
        failure = watch.write_failure
        if failure is not None:
            self.say_once(
                f"referee: {failure.filename}: {failure.strerror}; the drive goes on, and is kept in memory until its end; "
                "a referee that is killed cannot go on with it"
            )
        if watch.referee_restarts:
            self.say_once(
                f"referee: goes on with the drive after a restart, at {watch.drive.completion_percent:.1f} %",
                "restart",
            )
        if watch.world_restarts:
            self.say_once(
                "referee: time went back: the world was started anew, and so is the drive",
                f"world {watch.world_restarts}",
            )

    def _say_missing(self, topics, wall_s: float) -> None:
        if self._next_s is None:
            self._next_s = wall_s + _PATIENCE_S
        if wall_s >= self._next_s:
            self._next_s = wall_s + _PATIENCE_S
            self.say(f"referee: waiting for {' and '.join(topics)}")

    def _pace(self, wall_s: float, time_s: float):
        """How many times faster than the wall clock the drive went over the last seconds; None while that is not known."""
        self._marks = [
            mark
            for mark in self._marks
            if wall_s - mark[0] <= _RECENT_S + _LOG_S and mark[1] <= time_s
        ]
        self._marks.append((wall_s, time_s))
        first_wall_s, first_s = self._marks[0]
        return (time_s - first_s) / (wall_s - first_wall_s) if wall_s > first_wall_s else None

    def show(self, line: str) -> None:
        """How it goes now, instead of the line before where that can be."""
        if self._in_place:
            # The cursor waits at the beginning, so that what others print does not hang on to the end of this line.
            line = line[: max(shutil.get_terminal_size().columns - 1, 20)]
            self._write(f"\r\x1b[K{line}\r")
            self._standing = True
        else:
            self._write(line + "\n")

    def say_once(self, line: str, key: str = None) -> None:
        """Say a line unless it, or one by the same key, has been said."""
        if (key or line) not in self._told:
            self._told.add(key or line)
            self.say(line)

    def say(self, line: str) -> None:
        """A line that is to stay."""
        self._write(("\r\x1b[K" if self._standing else "") + line + "\n")
        self._standing = False

    def _write(self, text: str) -> None:
        try:
            self._stream.write(text)
            self._stream.flush()
        except (OSError, ValueError):
            pass


def progress_line(
    percent: float, speed_mps: float, cross_track_m: float, left_s: float, real_time_factor
) -> str:
    """Share of the route, m/s, m (positive to the left), seconds of the drive's time, times real time or None."""
    factor = "" if real_time_factor is None else f" {real_time_factor:.1f}x real time"
    minutes, seconds = divmod(int(round(left_s)), 60)
    return (
        f"referee: {percent:4.1f} % {speed_mps:4.1f} m/s  cross-track error {cross_track_m:+.2f} m"
        f"  {minutes:d}:{seconds:02d} left{factor}"
    )


def closing_line(figures: dict) -> str:
    """How the drive ended."""
    factor = figures["real_time_factor"]
    pace = "" if factor is None else f" ({factor:.1f} times real time)"
    return (
        f"referee: {figures['status']}: {figures['route_completion_percent']:.1f} % of {figures['route_length_m']:.0f} m in "
        f"{figures['duration_s']:.1f} s{pace}, cross-track error {figures['cross_track_rms_m']:.3f} m RMS, "
        f"{figures['cross_track_max_m']:.3f} m at worst; driving score {figures['driving_score']:.0f}"
    )
