"""The paths of the axles while the car's centre follows a path, with the slip of the tyres."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from sdc_common.geometry.polyline import Polyline
from sdc_common.geometry.segments import new_rows
from sdc_common.validation import check_non_negative, check_positive

# In a tighter bend the rear axle would not move at all, which no car can drive.
MAX_SLIP_SINE = 0.95


@dataclass(frozen=True)
class Axles:
    """Positions of the axles and stiffness of the tyres."""

    front_m: float  # distance from the car's centre, which follows the path, to the front axle [m]
    rear_m: float  # distance from the car's centre to the rear axle [m]
    # Slip angle of the front tyres per unit of lateral acceleration [rad/(m/s^2)]
    front_compliance: float
    # Slip angle of the rear tyres per unit of lateral acceleration [rad/(m/s^2)]
    rear_compliance: float

    def __post_init__(self):
        check_positive(front_m=self.front_m, rear_m=self.rear_m)
        check_non_negative(
            front_compliance=self.front_compliance, rear_compliance=self.rear_compliance
        )

    @property
    def wheelbase_m(self) -> float:
        """Return the distance between the axles [m]."""
        return self.front_m + self.rear_m

    @property
    def understeer_gradient(self) -> float:
        """Return the wheel angle that a unit of lateral acceleration adds [rad/(m/s^2)].

        Reference: R. Rajamani, Vehicle Dynamics and Control, 2nd ed., section 3.3.
        """
        return self.front_compliance - self.rear_compliance


def axle_path(
    line: Polyline, count: int, speed_mps: float, axles: Axles, ahead_m: float
) -> Polyline:
    """Return the path of an axle while the car's centre follows a line.

    In a bend the front axle runs outside of the centre, and the rear axle inside. A front axle on
    the centre's path would make the car cut the corner, by 0.9 m in a bend of 4 m radius.

    Args:
        line: path of the centre
        count: number of points of the line to use, from its start
        speed_mps: speed of the car [m/s]
        axles: geometry and tyres of the car
        ahead_m: distance of the axle ahead of the centre, negative for the rear axle [m]
    """
    numbers = line.numbers
    points = new_rows(count, numbers.are_arrays)
    geometry = numbers.points, numbers.lengths, numbers.headings
    rear = axles.rear_m, axles.rear_compliance
    numbers.function(_fill_axle_path)(points, *geometry, speed_mps, *rear, ahead_m)
    return Polyline(points)


def _fill_axle_path(
    path: Any,
    points: Any,
    lengths: Any,
    headings: Any,
    speed_mps: float,
    rear_m: float,
    rear_compliance: float,
    ahead_m: float,
) -> None:
    """Fill in the points of an axle's path, from the numbers of the centre's path.

    The slip angle u between path and car at the centre obeys du/ds = curvature - sin(u) / rear_m
    (kinematic bicycle, Rajamani, section 2.2). From point to point, u follows the solution for
    constant curvature. At speed the rear tyres slip outwards and turn the car into the bend, by
    their compliance times the lateral acceleration (section 3.1).
    """
    slip = 0.0
    last = len(path) - 1
    for i in range(len(path)):
        if i > 0:
            length = lengths[i - 1]
            sine = rear_m * (headings[i] - headings[i - 1]) / length
            steady = math.asin(min(max(sine, -MAX_SLIP_SINE), MAX_SLIP_SINE))
            if i == 1:
                slip = steady
            slip = steady + (slip - steady) * math.exp(-length * math.cos(steady) / rear_m)
        tyre_slip = 0.0
        if 0 < i < last:
            length = lengths[i - 1] + lengths[i]
            curvature = (headings[i + 1] - headings[i - 1]) / length
            tyre_slip = rear_compliance * curvature * speed_mps * speed_mps
        yaw = headings[i] - slip + tyre_slip
        x, y = points[i]
        path[i] = (x + ahead_m * math.cos(yaw), y + ahead_m * math.sin(yaw))
