"""Roads to plan on, and limits and margins to plan with."""

import math

import numpy as np

from sdc_common.planning.speed_profile import SpeedLimits
from sdc_package.obstacle_prediction import ObstacleMargins
from sdc_package.traffic_lights import TrafficLightMargins

OBSTACLES = ObstacleMargins(side_m=0.4, gap_m=5.0, car_front_m=2.35, car_width_m=2.0)
LIMITS = SpeedLimits(cruise_mps=10.0, lateral_mps2=3.0, acceleration_mps2=1.8, braking_mps2=2.5)
TRAFFIC_LIGHTS = TrafficLightMargins(gap_m=1.0, reaction_s=0.5, hardest_mps2=6.0, car_front_m=2.35)


def straight(length, step=1.0):
    return np.column_stack(
        [np.arange(0.0, length + step / 2, step), np.zeros(int(round(length / step)) + 1)]
    )


def bend(radius, angle, before=60.0, after=60.0):
    turned = np.arange(1.0, radius * angle) / radius
    arc = np.column_stack([before + radius * np.sin(turned), radius * (1.0 - np.cos(turned))])
    away = np.array([math.cos(turned[-1]), math.sin(turned[-1])])
    return np.vstack([straight(before), arc, arc[-1] + np.outer(np.arange(1.0, after), away)])
