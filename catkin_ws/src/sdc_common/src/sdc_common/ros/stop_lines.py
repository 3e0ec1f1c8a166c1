"""Stop lines of traffic lights, read from the bridge's messages."""

from __future__ import annotations

import math
from typing import NamedTuple

from sdc_common.geometry.route import Route
from sdc_common.ros.odometry import yaw_from_quaternion

# As CarlaTrafficLightStatus numbers them. At what is off or unknown the car drives on.
RED, YELLOW, GREEN = 0, 1, 2


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
        line = StopLine(
            light.transform.position.x + c * centre.x - s * centre.y,
            light.transform.position.y + s * centre.x + c * centre.y,
            0.5 * max(abs(size.x), abs(size.y)),
        )
        if not all(map(math.isfinite, line)):
            raise ValueError(f"a number of traffic light {light.id} is not finite")
        lines[light.id] = line
    return lines
