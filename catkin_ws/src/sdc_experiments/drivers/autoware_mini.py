"""The law and the parameters of autoware_mini's pure pursuit follower, with our planner and pedals.

It aims at the point of the path 1.2 s ahead, at least 6 m (release of March 2024).
"""

from math import atan, atan2, hypot, sin

LOOKAHEAD_TIME_S, LEAST_AHEAD_M, WHEEL_BASE_M = 1.2, 6.0, 2.789


class Driver:
    def __init__(self, mission):
        pass

    def wheel_angle(self, path, x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps):
        ahead_m = path.place(x_m, y_m).s_m + max(LEAST_AHEAD_M, LOOKAHEAD_TIME_S * speed_mps)
        to_x_m, to_y_m = (b - a for a, b in zip((x_m, y_m), path.line.point_at(ahead_m)))
        curvature = 2.0 * sin(atan2(to_y_m, to_x_m) - yaw_rad) / hypot(to_x_m, to_y_m)
        return atan(WHEEL_BASE_M * curvature)
