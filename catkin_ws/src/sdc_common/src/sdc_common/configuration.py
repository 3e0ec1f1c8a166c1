"""Find packages, and the parameters of their nodes, without a ROS master."""

from __future__ import annotations

import copy
import importlib
import os
from functools import lru_cache
from typing import Any


@lru_cache(maxsize=None)
def package_folder(package: str) -> str:
    """Return the folder with the data of a package, such as its config/.

    An installed wheel has them in share/ of the Python package. In a source tree they are in the
    folder of package.xml. Of an installed workspace, ROS has the place.
    """
    for path in importlib.import_module(package).__path__:
        shared, source = os.path.join(path, "share"), os.path.join(path, "..", "..")
        if os.path.isdir(shared):
            return shared
        if os.path.isfile(os.path.join(source, "package.xml")):
            return os.path.abspath(source)
    import rospkg  # Only ROS has it.

    return rospkg.RosPack().get_path(package)


def how_to_install(extra: str) -> str:
    """Return how a user installs what a feature needs, an extra of pyproject.toml."""
    if os.path.basename(package_folder("sdc_common")) == "share":
        return f"run pip install 'sdc-workshop[{extra}]'"
    step = "packages" if extra in ("cluster", "fast", "plots") else extra
    return f"run docker/prepare {step}, which needs a connection, and set up the terminal again"


def node_config(package: str, node: str) -> dict[str, Any]:
    """Return the parameters of a node, from its file in config/ of its package."""
    return copy.deepcopy(_values(os.path.join(package_folder(package), "config", f"{node}.yaml")))


@lru_cache(maxsize=None)
def _values(path: str) -> dict[str, Any]:
    import yaml  # The check of the words of a command runs with the standard library alone.

    with open(path, encoding="utf-8") as file:
        return yaml.safe_load(file)
