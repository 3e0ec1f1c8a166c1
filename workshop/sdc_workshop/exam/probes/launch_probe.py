"""Load launch files as roslaunch does, for a check that asks library_probe.py."""

from __future__ import annotations

from roslaunch.config import ROSLaunchConfig
from roslaunch.core import RLException
from roslaunch.xmlloader import XmlLoader, XmlParseException

_ATTRIBUTES = ("name", "package", "type", "output", "respawn")


def read(path: str, cases: list) -> list | str:
    """Return nodes and parameters for each list of arguments, or the message of roslaunch."""
    found = []
    for arguments in cases:
        config, loader = ROSLaunchConfig(), XmlLoader()
        # roslaunch sets it outside of the class, which has no default.
        loader.ignore_unset_args = False
        try:
            loader.load(path, config, argv=[*arguments], verbose=False)
        except (XmlParseException, RLException, ValueError) as error:
            return " ".join(str(error).split())
        nodes = [{name: getattr(node, name) for name in _ATTRIBUTES} for node in config.nodes]
        parameters = {name: parameter.value for name, parameter in config.params.items()}
        found.append({"nodes": nodes, "parameters": parameters})
    return found
