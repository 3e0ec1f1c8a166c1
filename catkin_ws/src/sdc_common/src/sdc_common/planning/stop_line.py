"""Stop lines of traffic lights."""

from __future__ import annotations

import math
from typing import NamedTuple

from sdc_common.geometry.route import Route

# As CarlaTrafficLightStatus numbers them. The car drives on at a light that is off or unknown.
RED, YELLOW, GREEN = 0, 1, 2
# A search begins and ends with whole segments.
_SLACK_M = 5.0


class StopLine(NamedTuple):
    """A stop line in the map frame."""

    x_m: float  # x of the middle [m]
    y_m: float  # y of the middle [m]
    half_width_m: float  # half of the line's width [m]
    z_m: float = math.nan  # height, NaN if it is not known [m]

    def along(self, route: Route, from_s_m: float, ahead_m: float) -> float | None:
        """Return the arc length at which a route crosses the line within a stretch, or None."""
        x_m, y_m = route.line.point_at(from_s_m)
        # Most lines of a map are too far away for a search.
        if math.hypot(self.x_m - x_m, self.y_m - y_m) > ahead_m + self.half_width_m + _SLACK_M:
            return None
        place = route.line.project(self.x_m, self.y_m, from_s_m, 0.0, ahead_m)
        return place.s_m if place.distance_m <= self.half_width_m else None
