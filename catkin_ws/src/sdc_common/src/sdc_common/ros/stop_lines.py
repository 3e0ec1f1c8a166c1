"""Stop lines of traffic lights, read from the messages of the CARLA bridge."""

from __future__ import annotations

import math
from typing import NamedTuple

from carla_msgs.msg import CarlaTrafficLightInfoList

from sdc_common.geometry.route import Route
from sdc_common.ros.odometry import yaw_from_quaternion

# As CarlaTrafficLightStatus numbers them. The car drives on at a light that is off or unknown.
RED, YELLOW, GREEN = 0, 1, 2


class StopLine(NamedTuple):
    """A stop line in the map frame.

    Attributes:
        x_m: x of the middle [m]
        y_m: y of the middle [m]
        half_width_m: half of the line's width [m]
    """

    x_m: float
    y_m: float
    half_width_m: float

    def along(self, route: Route, from_s_m: float, ahead_m: float) -> float | None:
        """Return the arc length at which a route crosses the line, or None if it does not.

        Args:
            route: the route
            from_s_m: arc length from which to search [m]
            ahead_m: length of the stretch to search [m]
        """
        place = route.project(self.x_m, self.y_m, from_s_m, 0.0, ahead_m)
        return place.s_m if place.distance_m <= self.half_width_m else None


def stop_lines(info: CarlaTrafficLightInfoList) -> dict[int, StopLine]:
    """Return the stop line of each traffic light, by the light's id.

    The line crosses the middle of the light's trigger volume.

    Raises:
        ValueError: a number is not finite
    """
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
