"""The values of a drive as the page shows them, collected from the newest messages."""

from __future__ import annotations

import math
from collections import OrderedDict
from typing import Any, Callable

import numpy as np
from carla_msgs.msg import (
    CarlaEgoVehicleStatus,
    CarlaTrafficLightInfoList,
    CarlaTrafficLightStatusList,
)
from nav_msgs.msg import Odometry
from sdc_msgs.msg import LaneOffset, ObstacleArray, SpeedReason

from sdc_cockpit.road_view import RoadView
from sdc_cockpit.sensor_view import SensorView
from sdc_cockpit.topic_feeds import Feed, decoded, seconds_of, stamp_of
from sdc_common.ros.conversion import stop_lines
from sdc_common.ros.odometry import GROUND_TRUTH, pose_and_speed, yaw_from_quaternion
from sdc_common.ros.refusal import refusing
from sdc_common.ros.speed_reason_publisher import DETAIL_TOPIC as SPEED_DETAIL
from sdc_common.ros.speed_reason_publisher import TOPIC as SPEED_REASON
from sdc_sim.ros.waypoint_messages import waypoint_rows
from sdc_sim.yaml_document import packaged_config

EGO = "/carla/ego_vehicle"
MEANINGS = packaged_config("report_page")["speed_reasons"]
ODOMETRY = EGO + "/odometry"
STATUS = EGO + "/vehicle_status"
OBSTACLES = EGO + "/obstacles"
MISSION = "/planner/mission_waypoints"
LOCAL_PATH = "/planner/local_waypoints"
LANE_OFFSET = "/camera/lane_offset"
LIGHT_INFO = "/carla/traffic_lights/info"
LIGHT_STATUS = "/carla/traffic_lights/status"
_REMEMBERED_STAMPS = 200
_MAX_PATH_POINTS = 300
# Without new odometry for so long, the simulated time stands still [s].
_STOPPED_AFTER_S = 0.5
# The planner repeats its reason, and the camera its offset in a lane, more often than this [s].
_VALUE_LASTS_S = 1.0
_LONGEST_REASON = 80


class DriveView:
    """Reads the feeds. Call `state` in one thread only.

    Args:
        wall_clock: returns the time since the epoch [s]
        on_odometry: called after each odometry

    Attributes:
        feeds: what to subscribe to
        road: the road, None before the first route
        speed_mps: speed of the car
        stamp: seconds and nanoseconds of the newest odometry, None before the first one
    """

    def __init__(
        self,
        wall_clock: Callable[[], float],
        on_odometry: Callable[[], None],
        map_path: Callable[[], str] = str,
    ):
        self._wall_clock, self._map_path = wall_clock, map_path
        self._on_odometry = on_odometry
        self._wall_times: OrderedDict[tuple[int, int], float] = OrderedDict()
        self._cache: dict[str, tuple[Any, Any]] = {}
        self._odometry_at_s = -math.inf
        self.road: RoadView | None = None
        self.road_number = 0
        self.stamp: tuple[int, int] | None = None
        self.feeds = [
            Feed(ODOMETRY, rests=True, callback=self._receive_odometry),
            Feed(GROUND_TRUTH, rests=True),
            Feed(MISSION, callback=self._receive_mission),
            Feed(LOCAL_PATH),
            Feed(STATUS, rests=True),
            Feed(OBSTACLES, rests=True),
            *map(Feed, (LIGHT_INFO, LIGHT_STATUS, SPEED_REASON, SPEED_DETAIL, LANE_OFFSET)),
        ]
        self._sensors = SensorView()
        self.feeds += self._sensors.feeds
        self._feeds = {feed.topic: feed for feed in self.feeds}

    def clear(self) -> None:
        """Forget the last drive."""
        for feed in self.feeds:
            feed.newest = None
        self._cache.clear()
        self._sensors.clear()
        self._wall_times.clear()
        self.road, self.stamp = None, None

    @property
    def speed_mps(self) -> float:
        """Return the speed of the newest odometry, 0 before the first one."""
        pose = self._value(ODOMETRY, _pose)
        return pose[3] if pose else 0.0

    @property
    def running(self) -> bool:
        """Return whether simulated time advances."""
        return self._wall_clock() - self._odometry_at_s < _STOPPED_AFTER_S

    def wall_time_of(self, stamp: tuple[int, int]) -> float:
        """Return the wall time at which the odometry of a stamp arrived; NaN if unknown."""
        return self._wall_times.get(stamp, math.nan)

    def _receive_odometry(self, message: Any) -> None:
        with refusing(ODOMETRY):
            stamp = stamp_of(message)
            if stamp != self.stamp:
                self._odometry_at_s = self._wall_clock()
            self.stamp = stamp
            self._wall_times.setdefault(stamp, self._odometry_at_s)
            if len(self._wall_times) > _REMEMBERED_STAMPS:
                self._wall_times.popitem(last=False)
        self._on_odometry()

    def _receive_mission(self, message: Any) -> None:
        with refusing(MISSION):
            points = np.array(waypoint_rows(message, "x", "y"), dtype=float).reshape(-1, 2)
            self.road = RoadView(points, self._map_path())
            self.road_number += 1

    def _value(self, topic: str, read: Callable[[Any], Any]) -> Any:
        """Return what `read` makes of the newest message; of a bad one, the value before it."""
        newest = self._feeds[topic].newest
        if newest is None:
            return None
        message, value = self._cache.get(topic, (None, None))
        if newest is not message:
            with refusing(topic):
                value = read(newest)
            self._cache[topic] = newest, value
        return value

    def state(self) -> dict[str, Any]:
        """Return the values for the page."""
        pose = self._value(ODOMETRY, _pose)
        path = self._value(LOCAL_PATH, _path) or []
        state = {
            "t": seconds_of(self.stamp) if self.stamp else None,
            "running": self.running,
            "pose": None,
            "speed": None,
            "plan": path[0][2] if path else None,
            "cross_track": None,
            "lane_offset": self._recent(LANE_OFFSET, _lane_offset),
            "path": path,
            "command": self._value(STATUS, _command),
            "obstacles": self._value(OBSTACLES, _obstacles) or [],
            "lights": self._lights(),
            "reason": self._reason(),
            "road": self.road_number,
            "progress": None,
        }
        if pose:
            x_m, y_m, yaw_rad, speed_mps = pose
            state["pose"] = [round(x_m, 3), round(y_m, 3), round(yaw_rad, 4)]
            state["speed"] = round(speed_mps, 3)
            if self.road is not None:
                # The car may estimate its pose; how well it drives, only the true one shows.
                place = (self._value(GROUND_TRUTH, _pose) or pose)[:3]
                state["cross_track"] = round(self.road.cross_track_m(*place), 3)
                state["progress"] = round(self.road.progress, 3)
        return {**state, **self._sensors.state(pose[:3] if pose else None)}

    def _recent(self, topic: str, read: Callable[[Any], Any]) -> Any:
        """Return the newest value with a stamp, None if the stack has not sent it for a while."""
        said = self._value(topic, read)
        if said is None or self.stamp is None:
            return None
        said_at_s, value = said
        return value if abs(seconds_of(self.stamp) - said_at_s) < _VALUE_LASTS_S else None

    def _reason(self) -> str | None:
        texts = [self._recent(topic, _speed_reason) for topic in (SPEED_REASON, SPEED_DETAIL)]
        return ": ".join(text for text in texts if text) if texts[0] else None

    def _lights(self) -> list[list]:
        places = self._value(LIGHT_INFO, _light_places) or {}
        states = self._value(LIGHT_STATUS, _light_states) or {}
        return [[*place, states.get(number, 4)] for number, place in places.items()]


def _speed_reason(message: Any) -> tuple[float, str]:
    reason = decoded(message, SpeedReason).reason
    return seconds_of(stamp_of(message)), MEANINGS.get(reason, reason[:_LONGEST_REASON])


def _lane_offset(message: Any) -> tuple[float, float | None]:
    offset_m = decoded(message, LaneOffset).offset_m
    value = round(offset_m, 3) if math.isfinite(offset_m) else None
    return seconds_of(stamp_of(message)), value


def _pose(message: Any) -> tuple[float, float, float, float]:
    return pose_and_speed(decoded(message, Odometry))


def _path(message: Any) -> list[list[float]]:
    rows = waypoint_rows(message, "x", "y", "v")[:_MAX_PATH_POINTS]
    if not all(math.isfinite(value) for row in rows for value in row):
        raise ValueError("a number of the path is not finite")
    return [[round(x, 2), round(y, 2), round(v, 2)] for x, y, v in rows]


def _command(message: Any) -> dict[str, Any]:
    control = decoded(message, CarlaEgoVehicleStatus).control
    values = {name: getattr(control, name) for name in ("throttle", "steer", "brake")}
    if not all(map(math.isfinite, values.values())):
        raise ValueError("a number of the command is not finite")
    return {
        **{name: round(value, 3) for name, value in values.items()},
        "hand_brake": bool(control.hand_brake),
        "gear": "R" if control.reverse else "D",
    }


def _box(pose: Any, size: Any) -> list[float]:
    yaw = yaw_from_quaternion(pose.orientation)
    numbers = (pose.position.x, pose.position.y, yaw, size.x, size.y, size.z)
    if not all(map(math.isfinite, numbers)):
        raise ValueError("a number of a box is not finite")
    return [round(number, 3) for number in numbers]


def _obstacles(message: Any) -> list[dict[str, Any]]:
    return [
        {"id": obstacle.id, "kind": obstacle.kind, "box": _box(obstacle.pose, obstacle.size)}
        for obstacle in decoded(message, ObstacleArray).obstacles
    ]


def _light_places(message: Any) -> dict[int, list[float]]:
    """Return x, y and yaw of each light, and x and y of the middle of its stop line."""
    info = decoded(message, CarlaTrafficLightInfoList)
    lines = stop_lines(info)
    places = {}
    for light in info.traffic_lights:
        pose, line = _box(light.transform, light.trigger_volume.size)[:3], lines[light.id]
        places[light.id] = [*pose, round(line.x_m, 2), round(line.y_m, 2)]
    return places


def _light_states(message: Any) -> dict[int, int]:
    lights = decoded(message, CarlaTrafficLightStatusList).traffic_lights
    return {light.id: light.state for light in lights}
