"""Traffic lights: which stop line the car must stop at."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from sdc_package.odometry import yaw_from_quaternion
from sdc_package.route import Route

# As CarlaTrafficLightStatus numbers them. At what is off or unknown the car drives on.
RED, YELLOW, GREEN = 0, 1, 2
# So slow a car can stop wherever it is.
_CREEPING_MPS = 0.5


@dataclass(frozen=True)
class LightCaution:
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


class StopLine(NamedTuple):
    """The middle of a stop line in the map, and half of its width: metres."""

    x_m: float
    y_m: float
    half_width_m: float

    def along(self, route: Route, from_s_m: float, ahead_m: float):
        """Where the route crosses it, as arc length, between two places; None where it does not."""
        place = route.project(self.x_m, self.y_m, from_s_m, 0.0, ahead_m)
        return place.s_m if place.distance_m <= self.half_width_m else None


def stop_lines(info) -> dict:
    """The StopLines by their lights' numbers out of a CarlaTrafficLightInfoList: a line runs through the middle of a light's trigger
    volume. Raises ValueError for numbers that are not finite."""
    lines = {}
    for light in info.traffic_lights:
        yaw = yaw_from_quaternion(light.transform.orientation)
        c, s = math.cos(yaw), math.sin(yaw)
        centre, size = light.trigger_volume.center, light.trigger_volume.size
        line = StopLine(light.transform.position.x + c * centre.x - s * centre.y, light.transform.position.y + s * centre.x + c * centre.y,
                        0.5 * max(abs(size.x), abs(size.y)))
        if not all(map(math.isfinite, line)):
            raise ValueError(f"a number of traffic light {light.id} is not finite")
        lines[light.id] = line
    return lines


class TrafficLights:
    """What the car knows of the lights, and which of them it is stopping for.

    stamped: whether the world says with stamps what they show; what is said without stamps is not heard any more then.
    """

    def __init__(self, caution: LightCaution):
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

    def stop_s(self, route: Route, from_s_m: float, speed_mps: float, braking_mps2: float, horizon_m: float):
        """The arc length at which the car's centre, now at `from_s_m`, must stop for the nearest of these lights, or None.

        A car that has begun to stop for a light goes on doing so until it is neither red nor yellow.
        """
        stops = []
        for number, state in self.states.items():
            line_s = self.lines[number].along(route, from_s_m, horizon_m) if number in self.lines else None
            if state not in (RED, YELLOW) or line_s is None or line_s <= from_s_m + self.caution.car_front_m:
                self._stops_for.discard(number)
                continue
            stop_s = line_s - self.caution.car_front_m - self.caution.gap_m
            if number in self._stops_for or self._can_stop(state, stop_s - from_s_m, speed_mps, braking_mps2):
                self._stops_for.add(number)
                stops.append(stop_s)
        return min(stops, default=None)

    def _can_stop(self, state: int, room_m: float, speed_mps: float, braking_mps2: float) -> bool:
        """Whether the car can stop: for yellow comfortably and in its place, for red with its front on the line at the latest."""
        if state == RED:
            room_m, braking_mps2 = room_m + self.caution.gap_m, self.caution.hardest_mps2
        room_m -= self.caution.reaction_s * speed_mps
        return speed_mps < _CREEPING_MPS or speed_mps * speed_mps <= 2.0 * braking_mps2 * max(room_m, 0.0)
