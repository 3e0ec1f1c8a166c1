"""Traffic lights: which stop line the car must stop at."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sdc_common.geometry.route import Route
from sdc_common.ros.stop_lines import RED, YELLOW, stop_lines

# So slow a car can stop wherever it is.
_CREEPING_MPS = 0.5


@dataclass(frozen=True)
class TrafficLightMargins:
    """gap_m is kept free between the car's front and the stop line; reaction_s is the time in which the car begins to brake;
    car_front_m lies between its centre and its front. It stops for yellow where its comfortable braking is enough, and for red
    where hardest_mps2 is: a car that cannot stop any more had better clear the crossing."""

    gap_m: float
    reaction_s: float
    hardest_mps2: float
    car_front_m: float

    def __post_init__(self):
        for name, value in vars(self).items():
            if not 0.0 <= value < math.inf:
                raise ValueError(f"traffic_lights {name} must be a number from 0, got {value}")


class TrafficLightMonitor:
    """What the car knows of the lights, and which of them it is stopping for.

    stamped: whether the world says with stamps what they show; what is said without stamps is not heard any more then.
    """

    def __init__(self, caution: TrafficLightMargins):
        self.caution = caution
        self.lines = {}
        self.states = {}
        self.stamped = False
        self._stops_for = set()

    def place(self, info) -> None:
        """Take a CarlaTrafficLightInfoList: where the lights are. Raises ValueError as stop_lines does."""
        self.lines = stop_lines(info)

    def show(self, statuses, stamped: bool) -> None:
        """Take CarlaTrafficLightStatus messages: what all lights show."""
        if stamped or not self.stamped:
            self.stamped = stamped and bool(statuses)
            self.states = {status.id: status.state for status in statuses}

    def stop_s(
        self, route: Route, from_s_m: float, speed_mps: float, braking_mps2: float, horizon_m: float
    ):
        """The arc length at which the car's centre, now at `from_s_m`, must stop for the nearest of these lights, or None.

        A car that has begun to stop for a light goes on doing so until it is neither red nor yellow.
        """
        stops = []
        for number, state in self.states.items():
            line_s = (
                self.lines[number].along(route, from_s_m, horizon_m)
                if number in self.lines
                else None
            )
            if (
                state not in (RED, YELLOW)
                or line_s is None
                or line_s <= from_s_m + self.caution.car_front_m
            ):
                self._stops_for.discard(number)
                continue
            stop_s = line_s - self.caution.car_front_m - self.caution.gap_m
            if number in self._stops_for or self._can_stop(
                state, stop_s - from_s_m, speed_mps, braking_mps2
            ):
                self._stops_for.add(number)
                stops.append(stop_s)
        return min(stops, default=None)

    def _can_stop(self, state: int, room_m: float, speed_mps: float, braking_mps2: float) -> bool:
        """Whether the car can stop: for yellow comfortably and in its place, for red with its front on the line at the latest."""
        if state == RED:
            room_m, braking_mps2 = room_m + self.caution.gap_m, self.caution.hardest_mps2
        room_m -= self.caution.reaction_s * speed_mps
        return speed_mps < _CREEPING_MPS or speed_mps * speed_mps <= 2.0 * braking_mps2 * max(
            room_m, 0.0
        )
