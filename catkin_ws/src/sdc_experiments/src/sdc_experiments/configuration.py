"""The configuration files of the car and of the world."""

from __future__ import annotations

import os
from typing import Any

from sdc_common.configuration import node_config
from sdc_sim.physics.vehicle_parameters import VehicleParameters, load_vehicle
from sdc_sim.scenario.packaged import folder_of


def node_parameters(node: str) -> dict[str, Any]:
    """Return the parameters of a node of sdc_package, from its file in config/."""
    return node_config("sdc_package", node)


def planner_parameters(on_map: bool) -> dict[str, Any]:
    """Return the parameters of local_planner, on a route or on a map."""
    streets = node_parameters("street_planner") if on_map else {}
    return {**node_parameters("local_planner"), **streets}


def vehicle_preset(name: str) -> VehicleParameters:
    """Return a vehicle of sdc_sim/config/vehicles."""
    return load_vehicle(os.path.join(folder_of("vehicle"), f"{name}.yaml"))
