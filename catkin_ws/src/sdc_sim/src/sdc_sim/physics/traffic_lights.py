"""Traffic lights: their positions and their phases."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Sequence

# In the order of the states of the bridge's messages.
COLOURS = ("red", "yellow", "green", "off")
RED, YELLOW, GREEN, OFF = range(4)

# First ID of the traffic lights in messages; obstacles start at 101.
FIRST_ID = 1001
LANE_WIDTH_M = 3.5
HEIGHT_M = 3.4
# The pole is beyond the stop line and to the right of the lane: a driver at the line sees its lamp.
_POLE_AHEAD_M = 4.0
_POLE_RIGHT_M = 2.7


class TrafficLightState(NamedTuple):
    """A light at one time: position of its pole, heading of the lane it controls, its colour."""

    id: int
    x_m: float
    y_m: float
    heading_rad: float
    state: int
    z_m: float = 0.0


@dataclass(frozen=True)
class TrafficLightPlan:
    """A light in a scenario."""

    x_m: float  # middle of the stop line in the map
    y_m: float  # middle of the stop line in the map
    heading_rad: float  # heading of the lane there
    phases: tuple[tuple[str, float], ...]  # (colour, seconds) of each phase; they repeat
    offset_s: float = 0.0  # position in the phases at the start of the simulation
    pole_ahead_m: float = _POLE_AHEAD_M  # distance of the pole beyond the stop line
    # Distance of the pole to the right of the middle of the lane.
    pole_right_m: float = _POLE_RIGHT_M
    z_m: float = 0.0  # height of the lane there

    @cached_property
    def pole_m(self) -> tuple[float, float]:
        """Position of the pole in the map."""
        c, s = math.cos(self.heading_rad), math.sin(self.heading_rad)
        x_m = self.x_m + self.pole_ahead_m * c + self.pole_right_m * s
        return x_m, self.y_m + self.pole_ahead_m * s - self.pole_right_m * c

    def state(self, elapsed_s: float) -> int:
        """Return the colour at this time after the start of the simulation."""
        # 1 us compensates rounding: a change happens at the tick at which it is due.
        left = (elapsed_s + self.offset_s + 1e-6) % sum(seconds for _, seconds in self.phases)
        for colour, seconds in self.phases:
            if left < seconds:
                return COLOURS.index(colour)
            left -= seconds
        return COLOURS.index(self.phases[-1][0])

    def line_m(self, light: TrafficLightState) -> tuple[float, float]:
        """Return the middle of the stop line ahead and to the left of the lamps."""
        yaw = light.heading_rad + math.pi
        c, s = math.cos(yaw), math.sin(yaw)
        east, north = self.x_m - light.x_m, self.y_m - light.y_m
        return c * east + s * north, c * north - s * east


def light_states(
    plans: Sequence[TrafficLightPlan], elapsed_s: float
) -> tuple[TrafficLightState, ...]:
    """Return all lights at this time after the start, or the reset, of the simulation."""
    return tuple(
        [
            TrafficLightState(
                number, *plan.pole_m, plan.heading_rad, plan.state(elapsed_s), plan.z_m
            )
            for number, plan in enumerate(plans, FIRST_ID)
        ]
    )
