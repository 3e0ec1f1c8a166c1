"""A steering method whose parameters can change while the car drives."""

from __future__ import annotations

from typing import Any

import rospy

from sdc_common.ros.node import offer_reload
from sdc_package.steering.axles import Axles
from sdc_package.steering.loader import load_steering, section_of
from sdc_package.steering.method import Steering


class LiveSteering(Steering):
    """The steering method that the parameters of the node name.

    The service ~reload reads them again: the answer to the next odometry uses the new method.

    Args:
        method: name of the first method; its parameters are those of the section of this name
        axles: geometry and tyres of the car

    Raises:
        ValueError: the method cannot be built
    """

    def __init__(self, method: str, axles: Axles):
        self._axles = axles
        self._build(method)
        offer_reload(self._reload)

    def wheel_angle(self, *arguments: Any, **named: Any) -> float:
        """See Steering.wheel_angle."""
        return self._method.wheel_angle(*arguments, **named)

    @property
    def acceleration_mps2(self) -> float | None:  # type: ignore[override]
        """See Steering."""
        return getattr(self._method, "acceleration_mps2", None)

    def _build(self, method: str) -> None:
        section = rospy.get_param("~" + section_of(method), None)
        self._method = load_steering(method, section, self._axles)

    def _reload(self) -> None:
        self._build(rospy.get_param("~steering_method", ""))
        rospy.loginfo("simple_controller: the steering has new parameters")
