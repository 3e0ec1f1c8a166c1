"""Traffic lights: where they stand and what they show at what time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

# As the bridge's messages number them.
COLOURS = ("red", "yellow", "green", "off")
RED, YELLOW, GREEN, OFF = range(4)

# Numbers of the lights in the messages; obstacles count from 101.
FIRST_ID = 1001
LANE_WIDTH_M = 3.5
# A pole stands so far beyond its stop line and to the right of the lane's middle: a driver who waits at the line sees its lamps.
_POLE_AHEAD_M = 4.0
_POLE_RIGHT_M = 2.7


class TrafficLightState(NamedTuple):
    """A light at one moment: its number, its pole's place, the heading of who must heed it, and what it shows."""

    id: int
    x_m: float
    y_m: float
    heading_rad: float
    state: int


@dataclass(frozen=True)
class TrafficLightPlan:
    """A light as a scenario describes it: the middle of the stop line in the map, the lane's heading there, and its phases
    (colour, seconds), which repeat for ever; at the start of the world it is offset_s into them."""

    x_m: float
    y_m: float
    heading_rad: float
    phases: tuple
    offset_s: float = 0.0

    def state(self, elapsed_s: float) -> int:
        """What it shows so long after the start of the world."""
        # A change falls on the tick that it is due at, however the sums of ticks and phases are rounded.
        left = (elapsed_s + self.offset_s + 1e-6) % sum(seconds for _, seconds in self.phases)
        for colour, seconds in self.phases:
            if left < seconds:
                return COLOURS.index(colour)
            left -= seconds
        return COLOURS.index(self.phases[-1][0])

    @property
    def pole_m(self) -> tuple:
        """Where its pole stands, (x, y) in the map."""
        c, s = math.cos(self.heading_rad), math.sin(self.heading_rad)
        return (
            self.x_m + _POLE_AHEAD_M * c + _POLE_RIGHT_M * s,
            self.y_m + _POLE_AHEAD_M * s - _POLE_RIGHT_M * c,
        )


class TrafficLights:
    """All the lights of a world."""

    def __init__(self, lights=()):
        self.all = tuple(lights)

    def lamps(self, elapsed_s: float) -> tuple:
        """Every Lamp so long after the start (or the reset) of the world."""
        return tuple(
            TrafficLightState(
                FIRST_ID + number, *light.pole_m, light.heading_rad, light.state(elapsed_s)
            )
            for number, light in enumerate(self.all)
        )
