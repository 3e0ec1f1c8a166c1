"""The parameters that a page can change while the car drives."""

from __future__ import annotations

from typing import Any

import rosgraph
import rospy
from std_srvs.srv import Trigger

from sdc_common.validation import is_number

_SIM, _CONTROLLER = "/sim", "/simple_controller"
_NOISE = ("position_m", "heading_rad", "speed_mps")
_DISTURBANCES = ("friction", "side_wind_mps", *(f"odometry_noise/{name}" for name in _NOISE))


def live_parameters() -> dict[str, float]:
    """Return the changeable parameters by their full names.

    These are the disturbances of the simulator, and the numbers in the section of the steering
    method, as far as the nodes run and offer the service ~reload.
    """
    found = {}
    disturbances = _flat(_parameters(_SIM))
    for name in _DISTURBANCES:
        if is_number(disturbances.get(name)):
            found[f"{_SIM}/{name}"] = disturbances[name]
    controller = _parameters(_CONTROLLER)
    section = str(controller.get("steering_method")).rpartition(":")[2]
    gains = controller.get(section)
    if isinstance(gains, dict):
        for name, value in gains.items():
            if is_number(value):
                found[f"{_CONTROLLER}/{section}/{name}"] = value
    return found


def change_parameter(name: str, value: float) -> str:
    """Change one of the live parameters and have its node use it.

    Returns:
        a line about the change

    Raises:
        ValueError: the parameter cannot be changed, or its node refused the value; the old value
            stays
    """
    before = live_parameters()
    if name not in before:
        raise ValueError(f"{name}: no running node offers to change it")
    node = _CONTROLLER if name.startswith(_CONTROLLER + "/") else _SIM
    rospy.set_param(name, value)
    try:
        answer = rospy.ServiceProxy(node + "/reload", Trigger)()
    except (rospy.ServiceException, rospy.ROSInterruptException) as error:
        rospy.set_param(name, before[name])
        raise ValueError(f"{name}: {node} did not respond ({error})") from error
    if not answer.success:
        rospy.set_param(name, before[name])
        raise ValueError(f"{name}: {answer.message}")
    return f"{name} is {value:g}"


def _parameters(node: str) -> dict[str, Any]:
    try:
        rosgraph.Master(rospy.get_name()).lookupService(node + "/reload")
        values = rospy.get_param(node, {})
    except (OSError, rosgraph.MasterException):
        return {}
    return values if isinstance(values, dict) else {}


def _flat(values: dict[str, Any]) -> dict[str, Any]:
    flat = {}
    for name, value in values.items():
        if isinstance(value, dict):
            flat.update({f"{name}/{inner}": number for inner, number in _flat(value).items()})
        else:
            flat[name] = value
    return flat
