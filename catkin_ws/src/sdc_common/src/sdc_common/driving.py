"""What world and car exchange in a tick: observations, paths and commands.

A message rounds some numbers: commands, speeds of obstacles and points of a path to 32-bit floats,
headings through a quaternion. They are rounded where these objects are made, so that a drive in one
process equals one through ROS, bit for bit.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass, field, replace
from typing import Any, Mapping, Sequence, Tuple

import numpy as np

_THREE_FLOAT32 = struct.Struct("<fff")
# What is higher or lower than this is on another level, such as below a bridge, where a car has
# room between both roads [m].
_LEVEL_M = 2.5
# A road between two places rises by at most this much for each metre.
_STEEPEST = 0.08

# What limits the planned speed, a name of speed_reasons in sdc_sim's config/report_page.yaml, is
# published when it changes, and again after this simulated time: at most the controller's timeout,
# so that the first plan after a timeout is published.
REASON_REPEAT_NS = 250_000_000
# x [m], y [m], target speed [m/s]
PathPoint = Tuple[float, float, float]


@dataclass(frozen=True)
class DetectedObstacle:
    """A box on the ground, in the map frame.

    Raises:
        ValueError: a number other than z_m is not finite
    """

    x_m: float  # position of the centre
    y_m: float
    yaw_rad: float  # heading, counter-clockwise from the x axis
    length_m: float  # size along the heading
    width_m: float
    speed_mps: float  # along the heading
    id: int = 0  # as in the collision events, 0 if it is not known
    # car, pedestrian, ..., as config/obstacle_kinds.yaml names them; "" if it is not known
    kind: str = ""
    z_m: float = math.nan  # height of the ground below it, NaN if it is not known

    def __post_init__(self):
        numbers = self.x_m, self.y_m, self.yaw_rad, self.length_m, self.width_m, self.speed_mps
        if not all(map(math.isfinite, numbers)):
            raise ValueError(f"a number of an obstacle is not finite: {self}")


@dataclass
class Observation:
    """What the software of the car receives in a tick. It has no true state, but measurements."""

    stamp_ns: int  # simulated time
    x_m: float  # position in the map
    y_m: float
    yaw_rad: float  # heading, counter-clockwise from the x axis
    speed_mps: float  # over the ground
    obstacles: Sequence[DetectedObstacle] = ()
    # State of each traffic light by its id
    light_states: Mapping[int, int] = field(default_factory=dict)
    readings: Any = None  # of further sensors in this tick, None if there are none
    z_m: float = math.nan  # height, NaN if it is not known

    @property
    def stamp_s(self) -> float:
        """Simulated time as rospy computes it from seconds and nanoseconds [s]."""
        seconds, nanoseconds = divmod(self.stamp_ns, 1_000_000_000)
        return float(seconds) + float(nanoseconds) / 1e9


@dataclass
class Path:
    """The path ahead of the car."""

    points: Sequence[PathPoint]  # two or more

    @classmethod
    def from_rows(cls, rows: np.ndarray) -> Path:
        """Return the path of (n, 3) rows x, y, target speed, rounded as in the message."""
        x, y, v = np.asarray(rows).astype(np.float32).T.tolist()
        return cls(tuple(zip(x, y, v)))


@dataclass
class Command:
    """What a driver demands until the next command."""

    throttle: float = 0.0  # 0..1
    steer: float = 0.0  # -1..1, positive to the RIGHT
    brake: float = 0.0  # 0..1
    hand_brake: bool = False
    reverse: bool = False
    stamp_ns: int = field(default=0, compare=False)  # of the observation that it answers, 0: none

    @classmethod
    def rounded(cls, throttle: float, steer: float, brake: float, stamp_ns: int = 0) -> Command:
        """Return a command with the precision of the message."""
        throttle, steer, brake = _THREE_FLOAT32.unpack(_THREE_FLOAT32.pack(throttle, steer, brake))
        return cls(throttle, steer, brake, stamp_ns=stamp_ns)

    def clamped(self) -> tuple[Command, bool]:
        """Return the command within its ranges, and whether it was outside them.

        Raises:
            ValueError: a value is NaN or infinite
        """
        if 0.0 <= self.throttle <= 1.0 and -1.0 <= self.steer <= 1.0 and 0.0 <= self.brake <= 1.0:
            return self, False
        for name in ("throttle", "steer", "brake"):
            if not math.isfinite(getattr(self, name)):
                raise ValueError(f"command refused: {name} is {getattr(self, name)}")
        limited = replace(
            self,
            throttle=min(max(self.throttle, 0.0), 1.0),
            steer=min(max(self.steer, -1.0), 1.0),
            brake=min(max(self.brake, 0.0), 1.0),
        )
        return limited, True


def points_as_sent(points_m: np.ndarray) -> np.ndarray:
    """Return (N, 2) waypoints as the message of a mission transports them [m]."""
    return np.asarray(points_m).astype(np.float32).astype(float)


def other_level(z_m: Any, other_m: Any, apart_m: float = 0.0) -> Any:
    """Return whether heights at places so far apart, or arrays of them, are on two levels [m].

    A height that is not known, NaN, is on each level.
    """
    return abs(z_m - other_m) > _LEVEL_M + _STEEPEST * apart_m


def quaternion(yaw_rad: float, pitch_rad: float = 0.0) -> tuple[float, float, float, float]:
    """Return x, y, z and w of an orientation; with a positive pitch the nose is down (REP 103)."""
    z, w = math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)
    s, c = math.sin(0.5 * pitch_rad), math.cos(0.5 * pitch_rad)
    return 0.0 - s * z, 0.0 + s * w, c * z, c * w  # no negative zero on a flat road


def yaw_as_sent(yaw_rad: float, pitch_rad: float = 0.0) -> float:
    """Return a heading after its conversion to a quaternion and back [rad]."""
    x, y, z, w = quaternion(yaw_rad, pitch_rad)
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
