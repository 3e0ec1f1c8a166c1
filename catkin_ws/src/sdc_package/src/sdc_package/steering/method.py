"""The interface of steering methods.

A new method needs no change in this package: write `steering_method: my_module:MySteering` in
config/simple_controller.yaml.
"""

from __future__ import annotations

import math

from sdc_package.local_path import ReferencePath

# A car on its tyres turns no faster. A higher yaw rate comes from a jump of the odometry.
_MAX_YAW_RATE_RADPS = 1.5


class Steering:
    """A steering method: computes the angle of the front wheels.

    The controller builds a method once, as `Method(axles, **parameters)`, with the parameters of
    the method's section in config/simple_controller.yaml. The constructor raises ValueError for a
    parameter that is out of range. A method may keep state from call to call, but it reads no
    clock, no message and no file.

    Attributes:
        acceleration_mps2: the acceleration that goes with the last wheel angle, None to leave it to
            the speed control [m/s^2]
    """

    acceleration_mps2: float | None = None

    def wheel_angle(
        self,
        path: ReferencePath,
        x_m: float,
        y_m: float,
        yaw_rad: float,
        speed_mps: float,
        yaw_rate_radps: float = 0.0,
    ) -> float:
        """Return the front wheel angle with which the car's centre follows the path.

        Args:
            path: the path to follow
            x_m: position of the car's centre in the map frame [m]
            y_m: position of the car's centre in the map frame [m]
            yaw_rad: heading of the car [rad]
            speed_mps: speed, not negative [m/s]
            yaw_rate_radps: rate of the heading [rad/s]

        Returns:
            wheel angle, positive left [rad]
        """
        raise NotImplementedError


def predicted_pose(
    x_m: float, y_m: float, yaw_rad: float, speed_mps: float, yaw_rate_radps: float, ahead_s: float
) -> tuple[float, float, float]:
    """Return the pose of a car that continues on its arc, which compensates for a delay.

    Args:
        x_m: position [m]
        y_m: position [m]
        yaw_rad: heading [rad]
        speed_mps: speed [m/s]
        yaw_rate_radps: rate of the heading, limited to what a car can do [rad/s]
        ahead_s: delay [s]

    Returns:
        x, y and yaw after the delay [m, m, rad]
    """
    turned = min(max(yaw_rate_radps, -_MAX_YAW_RATE_RADPS), _MAX_YAW_RATE_RADPS) * ahead_s
    middle = yaw_rad + 0.5 * turned
    ahead_m = speed_mps * ahead_s
    return x_m + ahead_m * math.cos(middle), y_m + ahead_m * math.sin(middle), yaw_rad + turned
