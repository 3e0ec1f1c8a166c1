"""A steering method of a user, as in the README of the package."""

from sdc_package.steering import Steering


class MySteering(Steering):
    def __init__(self, axles, gain):
        self.gain = gain

    def wheel_angle(self, path, x_m, y_m, yaw_rad, speed_mps, yaw_rate_radps=0.0):
        return -self.gain * path.nearest(x_m, y_m).cross_track_m


class NoSteering:
    pass
