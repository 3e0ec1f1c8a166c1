"""Where a car's axles run while its centre follows a path, with the slip of its tyres."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sdc_common.geometry.polyline import Polyline
from sdc_common.validation import check_non_negative, check_positive

# A bend so tight that the rear axle would stand still is no bend a car can drive.
_MOST_SLIP_SINE = 0.95


@dataclass(frozen=True)
class Axles:
    """Distances in metres from the car's centre, the point that follows the path, to its axles, and their cornering
    compliances: the tyres' slip angle a unit of lateral acceleration, rad/(m/s^2)."""

    front_m: float
    rear_m: float
    front_compliance: float
    rear_compliance: float

    def __post_init__(self):
        check_positive(front_m=self.front_m, rear_m=self.rear_m)
        check_non_negative(
            front_compliance=self.front_compliance, rear_compliance=self.rear_compliance
        )

    @property
    def wheelbase_m(self) -> float:
        """Front axle to rear axle."""
        return self.front_m + self.rear_m

    @property
    def understeer_gradient(self) -> float:
        """Wheel angle that lateral acceleration asks for beyond the geometric one, rad/(m/s^2) (R. Rajamani, Vehicle Dynamics and
        Control, 2nd ed., section 3.3)."""
        return self.front_compliance - self.rear_compliance


def front_axle_path(line: Polyline, count: int, speed_mps: float, axles: Axles) -> Polyline:
    """The line that the front axle follows while the car's centre follows the first `count` points of `line`.

    In a bend the front axle runs outside of the centre: steering the front axle along the centre's path would make the car cut
    the corner, by 0.9 m in a bend of 4 m radius.
    """
    return _axle_path(line, count, speed_mps, axles, axles.front_m)


def rear_axle_path(line: Polyline, count: int, speed_mps: float, axles: Axles) -> Polyline:
    """The line that the rear axle follows while the car's centre follows the first `count` points of `line`: inside of a bend."""
    return _axle_path(line, count, speed_mps, axles, -axles.rear_m)


def _axle_path(
    line: Polyline, count: int, speed_mps: float, axles: Axles, ahead_m: float
) -> Polyline:
    """The line of the point `ahead_m` ahead of the centre.

    The slip angle u between path and car at the centre obeys du/ds = curvature - sin(u) / rear_m (kinematic bicycle; R. Rajamani,
    Vehicle Dynamics and Control, 2nd ed., section 2.2); here it is advanced from point to point with the solution for constant
    curvature. At speed the rear tyres slip outwards and turn the car back into the bend, by their compliance times the lateral
    acceleration (the same, section 3.1).
    """
    points = []
    slip = None
    headings = line.headings
    for i in range(count):
        if i > 0:
            length = line.lengths[i - 1]
            sine = axles.rear_m * (headings[i] - headings[i - 1]) / length
            steady = math.asin(min(max(sine, -_MOST_SLIP_SINE), _MOST_SLIP_SINE))
            if slip is None:
                slip = steady
            slip = steady + (slip - steady) * math.exp(-length * math.cos(steady) / axles.rear_m)
        sideways = 0.0
        if 0 < i < count - 1:
            curvature = (headings[i + 1] - headings[i - 1]) / (
                line.lengths[i - 1] + line.lengths[i]
            )
            sideways = axles.rear_compliance * curvature * speed_mps * speed_mps
        yaw = headings[i] - (slip or 0.0) + sideways
        x, y = line.points[i]
        points.append((x + ahead_m * math.cos(yaw), y + ahead_m * math.sin(yaw)))
    return Polyline(points)
