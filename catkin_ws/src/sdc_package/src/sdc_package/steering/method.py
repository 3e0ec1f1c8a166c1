"""Steering methods behind one small interface, chosen by name.

A method is a class with `wheel_angle`, built from the car's axles and the figures of its section in
config/simple_controller.yaml. Methods of your own need no change here: `steering_method: my_module:MySteering`.
"""

from __future__ import annotations

import difflib
import importlib
import inspect
import math
from typing import Mapping

from sdc_package.local_path import ReferencePath
from sdc_package.steering.axles import Axles

METHODS = {
    "stanley": "sdc_package.steering.stanley:StanleySteering",
    "pure_pursuit": "sdc_package.steering.pure_pursuit:PurePursuitSteering",
    "kinematic": "sdc_package.steering.kinematic:KinematicSteering",
    "lqr": "sdc_package.steering.lqr:LqrSteering",
    "lqr_feedforward": "sdc_package.steering.lqr:LqrFeedforwardSteering",
}

# A car on its tyres turns no faster; a pose that was set anew, or a jump of the odometry, seems to.
_FASTEST_YAW_RATE_RADPS = 1.5


class Steering:
    """The interface of a steering method: how far to turn the front wheels.

    It is built once, as `Method(axles, **figures)`, where `figures` are the lines of its section of the configuration; its
    constructor raises ValueError for figures without sense. A method may remember what it needs from call to call, but it
    reads no clock, no message and no file.
    """

    def wheel_angle(
        self,
        path: ReferencePath,
        x_m: float,
        y_m: float,
        yaw_rad: float,
        speed_mps: float,
        yaw_rate_radps: float = 0.0,
    ) -> float:
        """Front wheel angle in radians, positive to the left, for a car whose centre is at (x_m, y_m) in the map frame and shall
        follow `path`; speed_mps is not negative."""
        raise NotImplementedError


def load_steering(method: str, figures: Mapping | None, axles: Axles) -> Steering:
    """Build the method of this name, or of this `module:Class`, from the figures of its section (None: there is no section).

    Raises ValueError, in one line that says how to mend it, for a name that is unknown, a module or class that is not found, figures
    that are missing, too many or without sense.
    """
    method_class = _find(method)
    section = section_of(method)
    if figures is not None and not isinstance(figures, Mapping):
        raise ValueError(f"section '{section}' must hold lines of 'name: figure', got {figures!r}")
    figures = dict(figures or {})
    try:
        signature = inspect.signature(method_class)
        wanted = [
            name
            for name, entry in list(signature.parameters.items())[1:]
            if entry.kind in (entry.POSITIONAL_OR_KEYWORD, entry.KEYWORD_ONLY)
        ]
        missing = [
            name
            for name in wanted
            if name not in figures and signature.parameters[name].default is inspect.Parameter.empty
        ]
        if missing:
            raise ValueError(
                f"section '{section}' lacks '{missing[0]}', which is a parameter of steering_method '{method}'"
            )
        takes_any = any(entry.kind is entry.VAR_KEYWORD for entry in signature.parameters.values())
        unknown = [] if takes_any else [name for name in figures if name not in wanted]
        if unknown:
            raise ValueError(
                f"section '{section}' holds '{unknown[0]}', which steering_method '{method}' does not know"
                + _did_you_mean(unknown[0], wanted)
            )
        steering = method_class(axles, **figures)
    except TypeError as error:
        raise ValueError(
            f"steering_method '{method}' cannot be built from section '{section}': {error}"
        ) from error
    except ValueError as error:
        if str(error).startswith("section "):
            raise
        raise ValueError(f"section '{section}': {error}") from error
    return steering


def section_of(method: str) -> str:
    """The name of the section that holds a method's figures: its own name, of `module:Class` the class."""
    return str(method).rpartition(":")[2]


def _find(method: str):
    if not isinstance(method, str) or not method:
        raise ValueError(
            f"steering_method must be one of {', '.join(METHODS)} or my_module:MySteering, got {method!r}"
        )
    if ":" not in method and method not in METHODS:
        raise ValueError(
            f"there is no steering_method '{method}'{_did_you_mean(method, METHODS)}; "
            f"there are {', '.join(METHODS)}, and my_module:MySteering for one of your own"
        )
    module_name, _, class_name = METHODS.get(method, method).partition(":")
    if not (
        module_name
        and class_name.isidentifier()
        and all(map(str.isidentifier, module_name.split(".")))
    ):
        raise ValueError(f"steering_method '{method}' is not of the form my_module:MySteering")
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name is None or not (module_name + ".").startswith(error.name + "."):
            raise ValueError(
                f"steering_method '{method}': module '{module_name}' asks for '{error.name}', "
                "which is not installed"
            ) from error
        raise ValueError(
            f"steering_method '{method}': there is no module '{module_name}'; put the folder of {module_name}.py "
            "on the PYTHONPATH"
        ) from error
    except (ImportError, SyntaxError) as error:
        raise ValueError(
            f"steering_method '{method}': module '{module_name}' cannot be loaded: {error}"
        ) from error
    names = [
        name
        for name, value in vars(module).items()
        if inspect.isclass(value) and callable(getattr(value, "wheel_angle", None))
    ]
    if not hasattr(module, class_name):
        raise ValueError(
            f"steering_method '{method}': module '{module_name}' has no class '{class_name}'"
            + _did_you_mean(class_name, [name for name in names if name != "Steering"])
        )
    if class_name not in names:
        raise ValueError(
            f"steering_method '{method}': '{class_name}' is no class with a method wheel_angle"
        )
    return getattr(module, class_name)


def _did_you_mean(word, known) -> str:
    close = difflib.get_close_matches(word, list(known), n=1, cutoff=0.5)
    return f": did you mean '{close[0]}'?" if close else ""


def predicted_pose(
    x_m: float, y_m: float, yaw_rad: float, speed_mps: float, yaw_rate_radps: float, ahead_s: float
):
    """(x_m, y_m, yaw_rad) of the car `ahead_s` from now, on the arc that it drives: makes up for the delay of computer and steering."""
    turned = min(max(yaw_rate_radps, -_FASTEST_YAW_RATE_RADPS), _FASTEST_YAW_RATE_RADPS) * ahead_s
    middle = yaw_rad + 0.5 * turned
    ahead_m = speed_mps * ahead_s
    return x_m + ahead_m * math.cos(middle), y_m + ahead_m * math.sin(middle), yaw_rad + turned
