"""A steering method that follows a line 0.8 m left of the route."""

import math

from sdc_package.steering.method import Steering
from sdc_package.steering.stanley_compensated import CompensatedStanleySteering

OFFSET_M = 0.8


class LeftOfTheLane(Steering):
    def __init__(self, axles):
        self.inner = CompensatedStanleySteering(axles, k=2.5, softening_mps=2.0, preview_s=0.025)

    def wheel_angle(self, path, x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps=0.0):
        x_m, y_m = x_m + OFFSET_M * math.sin(yaw_rad), y_m - OFFSET_M * math.cos(yaw_rad)
        return self.inner.wheel_angle(path, x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps)
