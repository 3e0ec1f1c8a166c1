"""The configuration files of the car and of the world."""

from __future__ import annotations

import os

import rospkg
import yaml

from sdc_sim.physics.vehicle_parameters import VehicleParameters, load_vehicle


def node_parameters(node: str) -> dict:
    """Return the parameters of a node of sdc_package, from its file in config/."""
    path = os.path.join(rospkg.RosPack().get_path("sdc_package"), "config", f"{node}.yaml")
    with open(path, encoding="utf-8") as file:
        return yaml.safe_load(file)


def vehicle_preset(name: str) -> VehicleParameters:
    """Return a vehicle of sdc_sim/config/vehicles."""
    folder = os.path.join(rospkg.RosPack().get_path("sdc_sim"), "config", "vehicles")
    return load_vehicle(os.path.join(folder, f"{name}.yaml"))
