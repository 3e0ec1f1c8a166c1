"""The law and the parameters of autoware_mini's pure pursuit follower, with our planner and pedals.

It aims at the waypoint two seconds ahead, at least 6 m, of waypoints 1 m apart.
"""

from math import atan, atan2, sin

import numpy as np

PLANNING_TIME_S, LEAST_AHEAD_M, WHEEL_BASE_M = 2.0, 6.0, 2.789


class Driver:
    def __init__(self, mission):
        self.points_m, self.nearest = mission.waypoints_m, 0

    def wheel_angle(self, path, x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps):
        away = self.points_m[self.nearest : self.nearest + 20] - (x_m, y_m)
        self.nearest += int(np.argmin((away**2).sum(axis=1)))
        ahead_m = max(LEAST_AHEAD_M, PLANNING_TIME_S * speed_mps)
        to_x_m, to_y_m = self.points_m[self.nearest :][: int(ahead_m) + 1][-1] - (x_m, y_m)
        return atan(WHEEL_BASE_M * 2.0 * sin(atan2(to_y_m, to_x_m) - yaw_rad) / ahead_m)
