"""The contents of the head-up display: text lines, fading notices and the frame rate."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from typing import Iterable

from sdc_common.driving import Command

_COMPASS_POINTS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
# Values of crossed_lane_markings in carla_msgs/CarlaLaneInvasionEvent.
_MARKINGS = {0: "other", 1: "broken", 2: "solid"}
UNKNOWN = "-"


@dataclass(frozen=True)
class Readings:
    """The values of the head-up display; None if unknown. The pose is in the map frame."""

    server_fps: float = 0.0
    client_fps: float = 0.0
    map_name: str | None = None
    time_s: float | None = None
    x_m: float | None = None
    y_m: float | None = None
    yaw_rad: float | None = None
    speed_mps: float | None = None
    command: Command = field(default_factory=Command)
    manual: bool = False


def compass(yaw_rad: float) -> tuple[int, str]:
    """Return the compass heading of a yaw angle.

    Args:
        yaw_rad: angle counter-clockwise from east [rad]

    Returns:
        degrees 0..359 clockwise from north, and the nearest of eight compass points
    """
    degrees = (90.0 - math.degrees(yaw_rad)) % 360.0
    return round(degrees) % 360, _COMPASS_POINTS[int((degrees + 22.5) // 45.0) % 8]


def clock(time_s: float) -> str:
    """Return a time [s] as hours, minutes and seconds: 0:00:00.0."""
    tenths = int(time_s * 10.0 + 1e-6)
    return f"{tenths // 36000}:{tenths // 600 % 60:02d}:{tenths // 10 % 60:02d}.{tenths % 10}"


def lines(readings: Readings) -> tuple[tuple[str, str], ...]:
    """Return the readings as rows of (label, value)."""
    time_s, speed, yaw = readings.time_s, readings.speed_mps, readings.yaw_rad
    heading = location = UNKNOWN
    if yaw is not None:
        degrees, point = compass(yaw)
        heading = f"{degrees}\N{DEGREE SIGN} {point}"
        location = f"{readings.x_m:.1f}, {readings.y_m:.1f}"
    return (
        ("Server", f"{readings.server_fps:.0f} FPS"),
        ("Client", f"{readings.client_fps:.0f} FPS"),
        ("Map", readings.map_name or UNKNOWN),
        ("Time", UNKNOWN if time_s is None else clock(time_s)),
        ("Speed", UNKNOWN if speed is None else f"{3.6 * speed:.0f} km/h"),
        ("Heading", heading),
        ("Location", location),
        ("Driver", "manual" if readings.manual else "autopilot"),
    )


def bars(command: Command) -> tuple[tuple[str, float, float], ...]:
    """Return the bars as rows of (label, value, minimum of the scale)."""
    return (
        ("Throttle", command.throttle, 0.0),
        ("Steer", command.steer, -1.0),
        ("Brake", command.brake, 0.0),
    )


def flags(command: Command) -> tuple[tuple[str, bool], ...]:
    """Return the indicators as rows of (label, is on)."""
    return (("Reverse", command.reverse), ("Hand brake", command.hand_brake))


def crossed_line_text(markings: Iterable[int]) -> str:
    """Return the notice for the values of crossed_lane_markings."""
    names = sorted({_MARKINGS.get(marking, "other") for marking in markings})
    return f"Crossed line: {' and '.join(names)}" if names else "Crossed line"


def collision_text(actor_id: int, name: str | None = None) -> str:
    """Return the notice for a collision with an actor."""
    return f"Collision with {name or f'actor {actor_id}'}"


class Notices:
    """Texts that fade out. A repeated text starts again; only the newest texts stay.

    Args:
        duration_s: time for which a text is visible [s]
        max_count: number of texts that are visible at the same time

    Raises:
        ValueError: duration_s is not positive.
    """

    def __init__(self, duration_s: float, max_count: int = 4):
        if not duration_s > 0.0:
            raise ValueError(f"the duration of a notice must be positive, got {duration_s}")
        self._duration_s = duration_s
        self._max_count = max_count
        self._start_times: dict[str, float] = {}

    def add(self, text: str, now_s: float) -> None:
        """Show a text from now on."""
        self._start_times.pop(text, None)
        self._start_times[text] = now_s
        while len(self._start_times) > self._max_count:
            del self._start_times[next(iter(self._start_times))]

    def visible(self, now_s: float) -> list[tuple[str, float]]:
        """Return rows of (text, opacity in 0..1), the oldest first.

        A text is opaque for the first half of its duration, then fades out.
        """
        self._start_times = {
            text: start
            for text, start in self._start_times.items()
            if now_s - start < self._duration_s
        }
        return [
            (text, min(1.0, 2.0 * (1.0 - (now_s - start) / self._duration_s)))
            for text, start in self._start_times.items()
        ]


class FrameRate:
    """The number of frames per second, averaged over a time window [s]."""

    def __init__(self, window_s: float = 2.0):
        self._window_s = window_s
        self._times: deque[float] = deque()

    def count(self, now_s: float) -> None:
        """Count a frame that arrives now."""
        self._times.append(now_s)

    def per_second(self, now_s: float) -> float:
        """Return the frame rate [1/s]; 0 for less than two frames."""
        while self._times and now_s - self._times[0] > self._window_s:
            self._times.popleft()
        if len(self._times) < 2 or self._times[-1] == self._times[0]:
            return 0.0
        return (len(self._times) - 1) / (self._times[-1] - self._times[0])
