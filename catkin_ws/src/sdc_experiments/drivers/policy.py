"""A linear policy, tuned by sdc_experiments.learning.train in the environment SdcRandomRoutes-v0.

This file, as a program, prints the weights. Actions are two ticks late there, as in many drives;
there is neither wind nor noise.
"""

from math import floor

import numpy as np

from sdc_common.driving import Command
from sdc_common.geometry.angles import wrap_angle
from sdc_common.geometry.road_line import road_route
from sdc_experiments.learning.observation import road_rows

WEIGHTS = [
    *(0.6206, 1.7824, -0.0021, -1.0914, -0.6408, -0.9436, 0.7119),
    *(0.3964, 0.4975, 0.0809, 0.0056),
]


class Driver:
    def __init__(self, mission):
        self.route = road_route(mission.waypoints_m)
        self.rows, self.s_m = road_rows(self.route), 0.0
        self.yaw_rad = mission.first.yaw_rad

    def step(self, observation):
        place = self.route.line.project(observation.x_m, observation.y_m, self.s_m, 3.0, 6.0)
        self.s_m, road = place.s_m, self.rows[floor(place.s_m + 0.5)]
        turn_radps = wrap_angle(observation.yaw_rad - self.yaw_rad) / 0.05
        self.yaw_rad = observation.yaw_rad
        error_rad = wrap_angle(observation.yaw_rad - place.heading_rad)
        seen = [place.cross_track_m, error_rad, turn_radps, *road[:4]]
        limits = road[len(road) // 2 :][:3]
        pace = [*np.minimum(limits - observation.speed_mps, 3.0), min(limits[1], 1.0)]
        steer = min(max(float(np.dot(WEIGHTS[:7], seen)), -1.0), 1.0)
        pedals = min(max(float(np.dot(WEIGHTS[7:], pace)), -1.0), 1.0)
        return Command.rounded(max(pedals, 0.0), steer, max(-pedals, 0.0))


if __name__ == "__main__":
    import gymnasium

    from sdc_experiments.learning.train import train

    class Late(gymnasium.vector.VectorWrapper):
        def reset(self, **arguments):
            self.waiting = 2 * [np.zeros(self.action_space.shape, np.float32)]
            return super().reset(**arguments)

        def step(self, actions):
            self.waiting.append(actions)
            return super().step(self.waiting.pop(0))

    make_vec = gymnasium.make_vec
    gymnasium.make_vec = lambda *names, **options: Late(make_vec(*names, **options))
    print(train(generations=16, policies=96, routes=8)[0].round(4).tolist())
