"""Build the steering method that the configuration names."""

from __future__ import annotations

import difflib
import importlib
import inspect
from types import ModuleType
from typing import Any, Callable, Iterable, Mapping

from sdc_package.steering.axles import Axles
from sdc_package.steering.method import Steering

METHODS = {
    "stanley": "sdc_package.steering.stanley:StanleySteering",
    "stanley_compensated": "sdc_package.steering.stanley_compensated:CompensatedStanleySteering",
    "pure_pursuit": "sdc_package.steering.pure_pursuit:PurePursuitSteering",
    "kinematic": "sdc_package.steering.kinematic:KinematicSteering",
    "lqr": "sdc_package.steering.lqr:LqrSteering",
    "lqr_feedforward": "sdc_package.steering.lqr:LqrFeedforwardSteering",
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
    method_class = _find_class(method)
    section = section_of(method)
    if parameters is not None and not isinstance(parameters, Mapping):
        raise ValueError(
            f"section '{section}' must hold lines of 'name: value', got {parameters!r}"
        )
    parameters = dict(parameters or {})
    _check_names(method, method_class, parameters)
    try:
        return method_class(axles, **parameters)
    except TypeError as error:
        raise ValueError(
            f"steering_method '{method}' cannot be built from section '{section}': {error}"
        ) from error
    except ValueError as error:
        raise ValueError(f"section '{section}': {error}") from error


def section_of(method: str) -> str:
    """Return the name of a method's section: its own name, or the class of `module:Class`."""
    return str(method).rpartition(":")[2]


def _check_names(
    method: str, method_class: Callable[..., Steering], parameters: Mapping[str, Any]
) -> None:
    """Raise ValueError for a parameter that is missing or unknown."""
    section = section_of(method)
    # The first parameter of the constructor is the car's axles.
    entries = list(inspect.signature(method_class).parameters.values())[1:]
    known = {
        entry.name: entry
        for entry in entries
        if entry.kind in (entry.POSITIONAL_OR_KEYWORD, entry.KEYWORD_ONLY)
    }
    for name, entry in known.items():
        if name not in parameters and entry.default is entry.empty:
            raise ValueError(
                f"section '{section}' lacks '{name}', a parameter of steering_method '{method}'"
            )
    takes_any = any(entry.kind is entry.VAR_KEYWORD for entry in entries)
    for name in parameters:
        if name not in known and not takes_any:
            raise ValueError(
                f"section '{section}' has '{name}', which is no parameter of steering_method "
                f"'{method}'{_suggestion(name, known)}"
            )


def _find_class(method: str) -> Callable[..., Steering]:
    """Return the class of a method. Raises ValueError as `load_steering` does."""
    if not isinstance(method, str) or not method:
        raise ValueError(
            f"steering_method must be one of "
            f"{', '.join(METHODS)} or my_module:MySteering, got {method!r}"
        )
    if ":" not in method and method not in METHODS:
        raise ValueError(
            f"there is no steering_method '{method}'{_suggestion(method, METHODS)}; write one of "
            f"{', '.join(METHODS)}, or my_module:MySteering for a method of your own"
        )
    module_name, _, class_name = METHODS.get(method, method).partition(":")
    if not all(map(str.isidentifier, [*module_name.split("."), class_name])):
        raise ValueError(f"steering_method '{method}' is not of the form my_module:MySteering")
    module = _import_module(method, module_name)
    method_class: Any = getattr(module, class_name, None)
    if _is_method(method_class):
        return method_class
    if method_class is not None:
        raise ValueError(
            f"steering_method '{method}': '{class_name}' is not a class with a method wheel_angle"
        )
    methods = [name for name, value in vars(module).items() if _is_method(value)]
    suggestion = _suggestion(class_name, [name for name in methods if name != "Steering"])
    raise ValueError(
        f"steering_method '{method}': module '{module_name}' has no class '{class_name}'"
        f"{suggestion}"
    )


def _is_method(value: Any) -> bool:
    return inspect.isclass(value) and callable(getattr(value, "wheel_angle", None))


def _import_module(method: str, module_name: str) -> ModuleType:
    """Import the module of a method. Raises ValueError as `load_steering` does."""
    try:
        return importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        if error.name is None or not (module_name + ".").startswith(error.name + "."):
            raise ValueError(
                f"steering_method '{method}': module '{module_name}' imports '{error.name}', "
                "which is not installed"
            ) from error
        raise ValueError(
            f"steering_method '{method}': there is no module '{module_name}'; put the folder of "
            f"{module_name}.py on the PYTHONPATH"
        ) from error
    except (ImportError, SyntaxError) as error:
        raise ValueError(
            f"steering_method '{method}': module '{module_name}' cannot be loaded: {error}"
        ) from error


def _suggestion(word: str, known: Iterable[str]) -> str:
    close = difflib.get_close_matches(word, list(known), n=1, cutoff=0.5)
    return f": did you mean '{close[0]}'?" if close else ""
