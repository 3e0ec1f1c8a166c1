"""Roads to plan on, and the shipped parameters of the planners to plan with."""

import numpy as np

from sdc_common.configuration import node_config
from sdc_package.local_path import ReferencePath
from sdc_package.planner_settings import PlannerSettings

SETTINGS = PlannerSettings.read(node_config("sdc_package", "local_planner").__getitem__)


def street_parameters():
    """Return the parameters of local_planner on a map."""
    configs = (node_config("sdc_package", name) for name in ("local_planner", "street_planner"))
    return {name: value for config in configs for name, value in config.items()}


def path_of(points):
    """Return the path along these points at 5 m/s."""
    path = ReferencePath()
    path.update([(x, y, 5.0) for x, y in points])
    return path


def straight(length, step=1.0):
    return np.column_stack(
        [np.arange(0.0, length + step / 2, step), np.zeros(int(round(length / step)) + 1)]
    )
