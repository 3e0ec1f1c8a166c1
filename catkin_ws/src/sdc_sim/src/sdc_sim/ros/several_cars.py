"""Several cars in the sim node: the setup of each, with topics of its own."""

from __future__ import annotations

import copy

from sdc_sim.ros.simulation_setup import SimulationSetup
from sdc_sim.scenario.several_cars import build_world

__all__ = ["build_world", "setups"]


def setups(first: SimulationSetup) -> list[SimulationSetup]:
    """Return that of the first car, and those of the other cars of its world."""
    found = [first]
    for name, simulation in list(first.world.cars.items())[1:]:
        one = copy.copy(first)
        one.number, one.simulation, one.ego = len(found) + 1, simulation, "/carla/" + name
        one.values = copy.copy(first.values)
        one.values.role_name, one.drive_log = name, None
        one.values.picture_feed += "_" + name
        one.pictures = first.pictures and first.pictures._replace(role_name=name)
        found.append(one)
    return found
