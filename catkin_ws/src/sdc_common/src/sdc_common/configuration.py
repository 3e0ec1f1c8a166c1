"""Find packages, and the parameters of their nodes, without a ROS master."""

from __future__ import annotations

import copy
import os
from functools import lru_cache
from typing import Any

import rospkg
import yaml


@lru_cache(maxsize=None)
def package_folder(package: str) -> str:
    """Return the folder of an installed package."""
    return rospkg.RosPack().get_path(package)


def node_config(package: str, node: str) -> dict[str, Any]:
    """Return the parameters of a node, from its file in config/ of its package."""
    return copy.deepcopy(_values(os.path.join(package_folder(package), "config", f"{node}.yaml")))


@lru_cache(maxsize=None)
def _values(path: str) -> dict[str, Any]:
    with open(path, encoding="utf-8") as file:
        return yaml.safe_load(file)
