"""Traffic lights: decide at which stop line the car stops."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Iterable

from sdc_common.geometry.route import Route
from sdc_common.planning.stop_line import RED, YELLOW, StopLine
from sdc_common.validation import check_non_negative

# A car this slow can stop anywhere.
_CREEP_SPEED_MPS = 0.5


@dataclass(frozen=True)
class TrafficLightMargins:
    """Distances and limits of a stop at a traffic light.

    The car stops for yellow if the braking of `stop_s` is enough, and for red if `hardest_mps2`
    is. A car that can no longer stop clears the crossing.
    """

    gap_m: float  # distance between the car's front and the stop line [m]
    reaction_s: float  # time until the car begins to brake [s]
    hardest_mps2: float  # maximum deceleration for a red light [m/s^2]
    car_front_m: float  # distance from the car's centre to its front [m]

    def __post_init__(self):
        check_non_negative(**{f"traffic_lights/{key}": value for key, value in vars(self).items()})


class TrafficLightMonitor:
    """The known traffic lights, and those that the car is stopping for.

    Attributes:
        lines: stop line of each light by its id
        states: state of each light by its id
        stamped: whether the states arrive with a stamp; states without a stamp are ignored then
    """

    def __init__(self, margins: TrafficLightMargins):
        self.margins = margins
        self.lines: dict[int, StopLine] = {}
        self.states: dict[int, int] = {}
        self.stamped = False
        self._stopping_for: set[int] = set()

    def set_states(self, statuses: Iterable[Any], stamped: bool) -> None:
        """Set the states of all lights.

        Args:
            statuses: CarlaTrafficLightStatus messages
            stamped: whether they arrived with a stamp
        """
        if stamped or not self.stamped:
            self.states = {status.id: status.state for status in statuses}
            self.stamped = stamped and bool(self.states)

    def stop_s(
        self, route: Route, from_s_m: float, speed_mps: float, braking_mps2: float, horizon_m: float
    ) -> float | None:
        """Return the arc length at which the car's centre must stop for the nearest light, or None.

        Once the car has begun to stop for a light, it continues until the light is neither red nor
        yellow.

        Args:
            route: the car's route
            from_s_m: arc length of the car's centre [m]
            speed_mps: speed of the car [m/s]
            braking_mps2: deceleration with which it stops for yellow [m/s^2]
            horizon_m: length of the route ahead of the car that is searched for stop lines [m]
        """
        stops = []
        for number, state in self.states.items():
            line_s_m = None
            if state in (RED, YELLOW) and number in self.lines:
                line_s_m = self.lines[number].along(route, from_s_m, horizon_m)
            if line_s_m is None or line_s_m <= from_s_m + self.margins.car_front_m:
                self._stopping_for.discard(number)
                continue
            stop_s_m = line_s_m - self.margins.car_front_m - self.margins.gap_m
            can_stop = self._can_stop(state, stop_s_m - from_s_m, speed_mps, braking_mps2)
            if number in self._stopping_for or can_stop:
                self._stopping_for.add(number)
                stops.append(stop_s_m)
        return min(stops, default=None)

    def _can_stop(self, state: int, room_m: float, speed_mps: float, braking_mps2: float) -> bool:
        """Return whether the car can stop, for red with its front at the line and hard braking."""
        if state == RED:
            room_m, braking_mps2 = room_m + self.margins.gap_m, self.margins.hardest_mps2
        free_m = max(room_m - self.margins.reaction_s * speed_mps, 0.0)
        return speed_mps < _CREEP_SPEED_MPS or speed_mps**2 <= 2.0 * braking_mps2 * free_m
