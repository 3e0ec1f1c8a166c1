"""Build the steering method that the configuration names."""

from __future__ import annotations

from typing import Any, Mapping

from sdc_common.validation import suggestion
from sdc_package.named import load_named
from sdc_package.steering.axles import Axles
from sdc_package.steering.method import Steering

# The class of each method, as `module:Class`. A class of a lab is imported only when it is chosen.
METHODS = {
    "stanley": "sdc_package.steering.stanley:StanleySteering",
    "stanley_compensated": "sdc_package.steering.stanley_compensated:CompensatedStanleySteering",
    "pure_pursuit": "sdc_package.steering.pure_pursuit:PurePursuitSteering",
    "kinematic": "sdc_package.steering.kinematic:KinematicSteering",
    "lqr": "sdc_package.steering.lqr:LqrSteering",
    "lqr_feedforward": "sdc_package.steering.lqr:LqrFeedforwardSteering",
    "mpc": "sdc_mpc.steering:MpcSteering",
}


def load_steering(method: str, parameters: Mapping[str, Any] | None, axles: Axles) -> Steering:
    """Build a steering method.

    Args:
        method: a name of METHODS, or `module:Class` for a method of your own
        parameters: section of the method in config/simple_controller.yaml, None if there is none
        axles: geometry and tyres of the car

    Raises:
        ValueError: there is no such method, or a parameter is missing, unknown or out of range; the
            message is one line with the fix
    """
    named = METHODS.get(method, str(method))
    module_name, _, class_name = named.partition(":")
    if not (module_name and class_name):
        fix = suggestion(
            str(method), METHODS, f"write one of {', '.join(METHODS)} or my_module:MySteering"
        )
        raise ValueError(f"there is no steering_method '{method}': {fix}")
    method_class = load_named(f"steering_method '{method}'", named)
    if not hasattr(method_class, "wheel_angle"):
        raise ValueError(
            f"steering_method '{method}': '{class_name}' is not a class with a method wheel_angle"
        )
    section = section_of(method)
    try:
        return method_class(axles, **(parameters or {}))
    except TypeError as error:
        raise ValueError(
            f"section '{section}' does not fit steering_method '{method}': {error}"
        ) from error
    except ValueError as error:
        raise ValueError(f"section '{section}': {error}") from error


def section_of(method: str) -> str:
    """Return the name of a method's section: its own name, or the class of `module:Class`."""
    return str(method).rpartition(":")[2]
