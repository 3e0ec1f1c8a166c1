"""The sensors of the car on the page: points of the lidars, positions of the GNSS."""

from __future__ import annotations

import math
from collections import deque
from typing import Any, Sequence

import numpy as np
from sensor_msgs.msg import NavSatFix, PointCloud2

from sdc_cockpit.topic_feeds import Feed, decoded
from sdc_common.geometry.geodesy import map_from_geodetic
from sdc_common.ros.refusal import refusing
from sdc_sim.sensors.model import MOUNTS_M

EGO = "/carla/ego_vehicle"
GNSS = EGO + "/gnss/front/gnss"
# Places of the lidars on the car by their topics.
LIDARS = {
    EGO + "/lidar/front/point_cloud": MOUNTS_M["lidar"],
    EGO + "/lidar/planar/point_cloud": MOUNTS_M["planar_lidar"],
}
_SHOWN_FIXES = 60
_SHOWN_POINTS = 400
_POINT_BYTES = 16


class SensorView:
    """Reads the feeds of the sensors.

    Attributes:
        feeds: what to subscribe to
    """

    def __init__(self) -> None:
        self._fixes: deque[list[float]] = deque(maxlen=_SHOWN_FIXES)
        self._scans: dict[str, tuple[Any, list[list[float]]]] = {}
        self.feeds = [Feed(GNSS, callback=self._receive_fix)]
        self.feeds += [Feed(topic, rests=True) for topic in LIDARS]

    def clear(self) -> None:
        """Forget the last drive."""
        self._fixes.clear()
        self._scans.clear()

    def state(self, pose: Sequence[float] | None) -> dict[str, Any]:
        """Return the values for the page; the pose of the car places the points."""
        points: list[list[float]] = []
        for feed in self.feeds[1:]:
            message, shown = self._scans.get(feed.topic, (None, []))
            if pose is not None and feed.newest is not message:
                with refusing(feed.topic):
                    shown = _points(feed.newest, LIDARS[feed.topic], pose)
                self._scans[feed.topic] = feed.newest, shown
            points += shown
        return {"fixes": list(self._fixes), "points": points}

    def _receive_fix(self, message: Any) -> None:
        with refusing(GNSS):
            fix = decoded(message, NavSatFix)
            if fix.status.status >= fix.status.STATUS_FIX:
                place = map_from_geodetic(fix.latitude, fix.longitude)
                if not all(map(math.isfinite, place)):
                    raise ValueError("a number of the position is not finite")
                self._fixes.append([round(number, 2) for number in place])


def _points(message: Any, mount_m: Sequence[float], pose: Sequence[float]) -> list[list[float]]:
    """Return some points of a scan in the map."""
    cloud = decoded(message, PointCloud2)
    if cloud.point_step != _POINT_BYTES:
        raise ValueError(f"a point has {cloud.point_step} bytes; x, y, z and intensity have 16")
    rows = np.frombuffer(cloud.data, np.float32).reshape(-1, 4)
    rows = rows[:: 1 + len(rows) // _SHOWN_POINTS, :3] + np.float32(mount_m)
    x_m, y_m, yaw_rad = pose
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    placed = np.column_stack(
        [x_m + c * rows[:, 0] - s * rows[:, 1], y_m + s * rows[:, 0] + c * rows[:, 1], rows[:, 2]]
    )
    return np.round(placed[np.isfinite(placed).all(axis=1)], 2).tolist()
