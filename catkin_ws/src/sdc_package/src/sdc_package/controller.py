"""The controller: follow the path ahead with throttle, brake and steer."""

from __future__ import annotations

from typing import Any, Callable

from sdc_common.driving import Command, Observation
from sdc_common.geometry.angles import wrap_angle
from sdc_common.validation import check_between
from sdc_package.actuation import PedalMap, SteeringMap
from sdc_package.local_path import ReferencePath
from sdc_package.pid import PidGains
from sdc_package.speed_control import SpeedControl, SpeedControlLimits
from sdc_package.steering.method import Steering

# After a longer gap between two observations the controller continues as after this one.
_MAX_STEP_S = 0.2


class Controller:
    """Answers an observation and the path ahead with a command.

    Args:
        parameter: returns the parameter of config/simple_controller.yaml with a given name
        steering: the steering method

    Attributes:
        steer: the last steer command, positive right
        last_answered: the last observation that `command` answered

    Raises:
        TypeError: a section lacks a parameter or has an unknown one
        ValueError: a parameter is out of range
    """

    def __init__(self, parameter: Callable[[str], Any], steering: Steering):
        self.stop_brake = parameter("stop_brake")
        check_between(0.0, 1.0, stop_brake=self.stop_brake)
        limits = SpeedControlLimits(**parameter("limits"))
        self.speed_control = SpeedControl(PidGains(**parameter("pid")), limits)
        self.steering_map = SteeringMap(**parameter("steering"))
        self.pedal_map = PedalMap(**parameter("pedals"))
        self.steering = steering
        self.steer = 0.0
        self.last_answered: Observation | None = None

    def command(self, observation: Observation, path: ReferencePath) -> Command | None:
        """Return the command that answers an observation with this path ahead."""
        x, y, yaw = observation.x_m, observation.y_m, observation.yaw_rad
        speed = observation.speed_mps
        step_s, yaw_rate = self._since_last(observation)
        # TODO 2.8: acceleration and wheel angle that the path asks for (until then: return None)
        target = path.nearest(x, y, self.speed_control.preview_m(speed))
        acceleration = self.speed_control.acceleration(
            target.speed_mps, target.acceleration_mps2, speed, step_s
        )
        wheel_angle = self.steering.wheel_angle(path, x, y, yaw, speed, yaw_rate)
        # ------------------------------------------------------------------------
        own_mps2 = getattr(self.steering, "acceleration_mps2", None)
        if own_mps2 is not None:
            acceleration = self.speed_control.acceleration_mps2 = own_mps2
        # TODO 2.9: pedals for this acceleration, steer for this angle (until then: return None)
        throttle, brake = self.pedal_map.pedals(acceleration)
        self.steer, _ = self.steering_map.command(wheel_angle, speed)
        # ------------------------------------------------------------------------
        return Command.rounded(throttle, self.steer, brake, observation.stamp_ns)

    def stop(self, observation: Observation | None, path: ReferencePath | None) -> Command:
        """Return a command that brakes along the last path; without one, it holds the steer."""
        self.speed_control.reset()
        if observation is not None and path is not None and not path.empty:
            pose = observation.x_m, observation.y_m, observation.yaw_rad
            wheel_angle = self.steering.wheel_angle(path, *pose, observation.speed_mps, 0.0)
            self.steer, _ = self.steering_map.command(wheel_angle, observation.speed_mps)
        return Command.rounded(0.0, self.steer, self.stop_brake)

    def _since_last(self, observation: Observation) -> tuple[float, float]:
        """Return the time since the last answered observation [s], and the yaw rate [rad/s]."""
        last, self.last_answered = self.last_answered, observation
        if last is None:
            return 0.0, 0.0
        step_s = min(max(observation.stamp_s - last.stamp_s, 0.0), _MAX_STEP_S)
        turned = wrap_angle(observation.yaw_rad - last.yaw_rad)
        return step_s, turned / step_s if step_s > 0.0 else 0.0
