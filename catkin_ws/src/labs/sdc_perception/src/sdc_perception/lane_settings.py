"""Dimensions of the road, and the noise that the lane tracker assumes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sdc_common.validation import check_positive


@dataclass(frozen=True)
class LaneSettings:
    """Dimensions of the road, and the noise that the tracker assumes; all positive."""

    lane_width_m: float  # width of a lane [m]
    start_m: float  # standard deviation of the offset at the start [m]
    start_rad: float  # of the heading at the start [rad]
    start_1pm: float  # of the curvature at the start [1/m]
    knot_1pm: float  # of the change of the curvature from a knot to the next [1/m]
    lasting_1pm: float  # greatest curvature of a bend of which no end is expected [1/m]
    kept_1pm: float  # the same while the car keeps to one side where the road divides [1/m]
    drift_m: float  # of the odometry's error across the road, per square root of a metre [m]
    drift_rad: float  # of the odometry's heading error, per square root of a metre [rad]
    drift_1pm: float  # of the error of a curvature ahead, per square root of a metre [1/m]
    # The same, as a share of the change of the curvature from a knot to the next
    drift_share: float
    known_m: float  # deviation of the lane's position up to which it is known without markings [m]
    visible_m: float  # deviation of the lane's position up to which the lane is visible [m]
    lost_m: float  # deviation next to the car at which the confidence is zero [m]

    def __post_init__(self):
        check_positive(**vars(self))

    @property
    def lines_m(self) -> np.ndarray:
        """Return the offsets (3,) of right edge, dashes and left edge from the centre [m]."""
        return self.lane_width_m * np.array([-0.5, 0.5, 1.5])
