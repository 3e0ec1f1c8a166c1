"""What the head-up display writes: lines from numbers, notices that fade, and the rate of frames. Nothing is drawn here."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

from sdc_sim.physics.vehicle import VehicleCommand

_POINTS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
# Values of crossed_lane_markings in carla_msgs/CarlaLaneInvasionEvent.
_MARKINGS = {0: "other", 1: "broken", 2: "solid"}
NOTHING = "-"


@dataclass(frozen=True)
class Readings:
    """What is known of the drive; None is not yet known. Pose in the map frame (x east, y north: REP 103)."""

    server_fps: float = 0.0
    client_fps: float = 0.0
    map_name: str | None = None
    time_s: float | None = None
    x_m: float | None = None
    y_m: float | None = None
    yaw_rad: float | None = None
    speed_mps: float | None = None
    command: VehicleCommand = field(default_factory=VehicleCommand)
    manual: bool = False


def compass(yaw_rad: float):
    """(degrees 0..359 clockwise from north, one of eight points of the compass) of a yaw counter-clockwise from east."""
    degrees = (90.0 - math.degrees(yaw_rad)) % 360.0
    return round(degrees) % 360, _POINTS[int((degrees + 22.5) // 45.0) % 8]


def clock(time_s: float) -> str:
    """Hours, minutes and seconds as 0:00:00.0."""
    tenths = int(time_s * 10.0 + 1e-6)
    return f"{tenths // 36000}:{tenths // 600 % 60:02d}:{tenths // 10 % 60:02d}.{tenths % 10}"


def lines(readings: Readings):
    """The figures as rows of (label, value)."""
    placed = readings.x_m is not None
    degrees, point = compass(readings.yaw_rad) if placed else (0, "")
    return (
        ("Server", f"{readings.server_fps:.0f} FPS"),
        ("Client", f"{readings.client_fps:.0f} FPS"),
        ("Map", readings.map_name or NOTHING),
        ("Time", NOTHING if readings.time_s is None else clock(readings.time_s)),
        ("Speed", f"{3.6 * readings.speed_mps:.0f} km/h" if placed else NOTHING),
        ("Heading", f"{degrees}\N{DEGREE SIGN} {point}" if placed else NOTHING),
        ("Location", f"{readings.x_m:.1f}, {readings.y_m:.1f}" if placed else NOTHING),
        ("Driver", "manual" if readings.manual else "autopilot"),
    )


def bars(command: VehicleCommand):
    """The bars as rows of (label, value, least value): pedals fill from the left, steer from the middle."""
    return (
        ("Throttle", command.throttle, 0.0),
        ("Steer", command.steer, -1.0),
        ("Brake", command.brake, 0.0),
    )


def flags(command: VehicleCommand):
    """The lamps as rows of (label, whether it is lit)."""
    return (("Reverse", command.reverse), ("Hand brake", command.hand_brake))


def crossed_line_text(markings) -> str:
    """What is said of the numbers in crossed_lane_markings."""
    names = sorted({_MARKINGS.get(marking, "other") for marking in markings})
    return f"Crossed line: {' and '.join(names)}" if names else "Crossed line"


def collision_text(actor: int, name: str | None = None) -> str:
    """What is said of a collision with an actor."""
    return f"Collision with {name or f'actor {actor}'}"


class Notices:
    """Messages that fade. The same message again is renewed, not repeated; the newest `most` are kept."""

    def __init__(self, duration_s: float, most: int = 4):
        if not duration_s > 0.0:
            raise ValueError(f"the duration of a notice must be positive, got {duration_s}")
        self._duration_s = duration_s
        self._most = most
        self._said_at = {}

    def say(self, text: str, now_s: float) -> None:
        """Show `text` from `now_s` on."""
        self._said_at.pop(text, None)
        self._said_at[text] = now_s
        while len(self._said_at) > self._most:
            del self._said_at[next(iter(self._said_at))]

    def visible(self, now_s: float):
        """Rows of (text, strength in 0..1), the oldest first; full strength for the first half of the time."""
        self._said_at = {
            text: said for text, said in self._said_at.items() if now_s - said < self._duration_s
        }
        return [
            (text, min(1.0, 2.0 * (1.0 - (now_s - said) / self._duration_s)))
            for text, said in self._said_at.items()
        ]


class FrameRate:
    """Frames per second over the last `window_s` seconds."""

    def __init__(self, window_s: float = 2.0):
        self._window_s = window_s
        self._times = deque()

    def count(self, now_s: float) -> None:
        """A frame came at `now_s`."""
        self._times.append(now_s)

    def per_second(self, now_s: float) -> float:
        """The rate; 0 until two frames have come."""
        while self._times and now_s - self._times[0] > self._window_s:
            self._times.popleft()
        if len(self._times) < 2 or self._times[-1] == self._times[0]:
            return 0.0
        return (len(self._times) - 1) / (self._times[-1] - self._times[0])
