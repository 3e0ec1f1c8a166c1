"""The driver of the lab: what you have written decides on each path of the car."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Callable, Sequence

import numpy as np

from sdc_behaviour.gaps import OnLane
from sdc_behaviour.junction import may_enter, time_in_space
from sdc_behaviour.lanes import predicted
from sdc_behaviour.manoeuvre import LaneProposal, LaneScene, acceleration_mps2, choose
from sdc_behaviour.roads import GiveWayLine
from sdc_common.driving import DetectedObstacle, Observation, Path
from sdc_common.geometry.polyline import Polyline
from sdc_map.network import Network

CAR_M = 4.7
# The space of a junction that two need: their centres are nearer than this to the crossing point.
SPACE_M = 5.0
_MARGIN_S = 1.5  # time between the car and a road user with right of way in a junction
_TIMES_S = np.arange(0.0, 9.01, 0.25)
_DECIDE_TICKS = 10  # ticks between two decisions
_LOOK_TICKS = 3  # ticks between two looks at a junction
_ASIDE_MPS = 1.3  # sideways speed of a lane change
_LATE_S = 0.3  # delay with which the car follows a change of its speed
_PATH_M = 24  # length of the path ahead of the car
_NEAR_M = 150.0  # road users farther away do not count
_ALONG_RAD = 0.6  # greatest angle to a lane of a road user that drives along it
_ASIDE_M = 1.3  # greatest distance from the middle of a lane of a road user on it
_LATE_MPS2 = 5.0  # a car that must brake harder than this to stop at the line drives on
_LATEST = 0.6  # least share of its acceleration with which a car enters from the line
_AT_LINE_M = 3.0  # the decision is final within this distance of the line


class LaneRoad:
    """The lanes of the car's road, which run beside one another, from right to left.

    Args:
        network: the streets
        lanes: ids of the parts of each lane, in order
        lines: the lines at which the car gives way
    """

    def __init__(
        self, network: Network, lanes: Sequence[Sequence[str]], lines: Sequence[GiveWayLine] = ()
    ):
        self.network, self.lines, self.number = network, lines, len(lanes)
        parts = [network.lanes[name].points_m for name in lanes[0]]
        points = np.vstack([parts[0], *(part[1:] for part in parts[1:])])
        self.line = Polyline(points.tolist())
        self.width_m = network.lanes[lanes[0][0]].width_m

    def on_lane(self, user: DetectedObstacle, near_m: float) -> OnLane | None:
        """Return a road user as one on a lane of this road, None if it is on none."""
        place = self.line.project(user.x_m, user.y_m, near_m, _NEAR_M, _NEAR_M)
        number = round(place.cross_track_m / self.width_m)
        heading = math.remainder(user.yaw_rad - place.heading_rad, 2.0 * math.pi)
        aside = abs(place.cross_track_m - number * self.width_m)
        if not 0 <= number < self.number or aside > _ASIDE_M or abs(heading) > _ALONG_RAD:
            return None
        return OnLane(place.s_m, user.speed_mps, user.length_m, number)


class BehaviourDriver:
    """Plans the path of the car; its `plan` is a planner of the library.

    Args:
        road: the road along which it drives
        chooses: what chooses the manoeuvre
        options: how it decides, fields of its scenes: limit_mps, rss, politeness

    Attributes:
        scene: what it decided about in the last step
        acceleration_mps2: what it wants [m/s^2]
        reason: what limits its speed
    """

    def __init__(
        self,
        road: LaneRoad,
        chooses: Callable[[LaneScene], LaneProposal] = choose,
        **options: Any,
    ):
        self._road, self._choose = road, chooses
        self._offset_m, self._ticks, self._entered_m = 0.0, 0, -math.inf
        self.scene = LaneScene(OnLane(0.0, 0.0, CAR_M), lanes=road.number, **options)
        self._proposal = LaneProposal(0, self.scene.limit_mps)
        self.reason, self.acceleration_mps2 = "", 0.0

    def plan(self, observation: Observation) -> Path:
        """Return the path ahead, with the speed at each of its points."""
        line, seen = self._road.line, observation
        if self._ticks:
            place = line.project(seen.x_m, seen.y_m, self.scene.own.s_m, 3.0, 10.0)
        else:
            place = line.nearest(seen.x_m, seen.y_m)
        self.scene = scene = self._scene(place.s_m, seen)
        if self._ticks % _DECIDE_TICKS == 0:
            self._proposal = self._choose(scene)
        self._ticks += 1
        target_m = self._proposal.lane * self._road.width_m
        lanes = {self._proposal.lane}
        if abs(self._offset_m - target_m) > 0.5 * self._road.width_m - 0.8:
            lanes.add(round(self._offset_m / self._road.width_m))
        self.acceleration_mps2 = a = acceleration_mps2(scene, self._proposal.speed_mps, lanes)
        rows = []
        for ahead_m in range(0, _PATH_M, 2):
            s_m = place.s_m + ahead_m
            x, y = line.point_at(s_m)
            heading = line.heading_at(s_m)
            left_m = self._moved(target_m, ahead_m / max(seen.speed_mps, 3.0))
            x, y = x - left_m * math.sin(heading), y + left_m * math.cos(heading)
            # The car answers late: it gets the speed that it will have then.
            way_m = ahead_m + _LATE_S * seen.speed_mps
            rows.append((x, y, math.sqrt(max(seen.speed_mps**2 + 2.0 * a * way_m, 0.0))))
        self._offset_m = self._moved(target_m, 0.05 if seen.speed_mps > 1.0 else 0.0)
        return Path.from_rows(np.array(rows))

    def _moved(self, target_m: float, time_s: float) -> float:
        """Return the distance from the right lane after so much time of a lane change [m]."""
        step_m = _ASIDE_MPS * time_s
        return self._offset_m + min(max(target_m - self._offset_m, -step_m), step_m)

    def _scene(self, s_m: float, seen: Observation) -> LaneScene:
        own = OnLane(s_m, seen.speed_mps, CAR_M, self._proposal.lane)
        found = [(obstacle, self._road.on_lane(obstacle, s_m)) for obstacle in seen.obstacles]
        others = tuple(place for _, place in found if place is not None)
        elsewhere = [obstacle for obstacle, place in found if place is None]
        stop_m = self.scene.stop_m
        if self._ticks % _LOOK_TICKS == 0:
            stop_m = self._line_m(own, elsewhere)
        self.reason = "" if math.isinf(stop_m) else "right_of_way"
        return replace(self.scene, own=own, others=others, stop_m=stop_m)

    def _line_m(self, own: OnLane, users: Sequence[DetectedObstacle]) -> float:
        """Return the place of the next line if the car must not enter the junction, else inf."""
        front_m = own.s_m + 0.5 * CAR_M
        for line in self._road.lines:
            to_line_m = line.line_m - front_m
            too_late = own.speed_mps**2 > 2.0 * _LATE_MPS2 * to_line_m
            if not 0.0 < to_line_m < 60.0 or too_late or line.line_m == self._entered_m:
                continue
            # At the earliest, and at the latest.
            enters_s = self._time_s(own, line.meets_m - SPACE_M - 1.0, 1.0)
            leaves_s = self._time_s(own, line.meets_m + SPACE_M + 1.0, _LATEST)
            space_m, network = np.array(line.space_m), self._road.network
            ways = (predicted(network, user, _TIMES_S) for user in users)
            others = [time_in_space(way, _TIMES_S, space_m, SPACE_M) for way in ways]
            if not may_enter((enters_s, leaves_s), others, _MARGIN_S):
                return line.line_m
            if to_line_m < _AT_LINE_M:
                self._entered_m = line.line_m  # it does not change its mind on the line
        return math.inf

    def _time_s(self, own: OnLane, at_m: float, share: float) -> float:
        """Return the time until the car is at a place, with a share of its acceleration [s]."""
        a, way_m = share * self.scene.rss.accelerating_mps2, max(at_m - own.s_m, 0.0)
        limit_mps = max(self.scene.limit_mps, own.speed_mps)
        until_m = (limit_mps**2 - own.speed_mps**2) / (2.0 * a)
        if way_m <= until_m:
            return (math.sqrt(own.speed_mps**2 + 2.0 * a * way_m) - own.speed_mps) / a
        return (limit_mps - own.speed_mps) / a + (way_m - until_m) / limit_mps
