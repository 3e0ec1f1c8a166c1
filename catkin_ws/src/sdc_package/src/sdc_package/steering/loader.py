"""Build the steering method that the configuration names."""

from __future__ import annotations

import importlib
from typing import Any, Mapping

from sdc_common.validation import suggestion
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
# A student's workspace has the package of a lab only after this command.
_COMMANDS_OF_LABS = {"sdc_mpc": "./workshop/start --lab mpc DIR"}


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
    module_name, _, class_name = METHODS.get(method, str(method)).partition(":")
    if not (module_name and class_name):
        fix = suggestion(
            str(method), METHODS, f"write one of {', '.join(METHODS)} or my_module:MySteering"
        )
        raise ValueError(f"there is no steering_method '{method}': {fix}")
    try:
        method_class: Any = getattr(importlib.import_module(module_name), class_name)
    except (ImportError, SyntaxError, AttributeError) as error:
        fix = f"the folder of {module_name}.py must be on the PYTHONPATH"
        missing_package = getattr(error, "name", None)
        if missing_package in _COMMANDS_OF_LABS:
            command = _COMMANDS_OF_LABS[missing_package]
            fix = f"{command} in the folder of the project adds it to the workspace DIR"
        raise ValueError(f"steering_method '{method}' cannot be loaded: {error}; {fix}") from error
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
