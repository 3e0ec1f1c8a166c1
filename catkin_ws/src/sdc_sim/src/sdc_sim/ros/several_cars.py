"""Several cars in the sim node: the setup of each, with topics of its own."""

from __future__ import annotations

import copy
from typing import Iterator

from sdc_sim.ros.simulation_setup import SimulationSetup
from sdc_sim.scenario.several_cars import build_world

__all__ = ["build_world", "setups"]


def setups(first: SimulationSetup) -> list[SimulationSetup]:
    """Return the setups of all cars, which differ in name, simulation and pictures.

    Args:
        first: that of the first car, whose world has all of them
    """
    return [first, *_others(first)]


def _others(first: SimulationSetup) -> Iterator[SimulationSetup]:
    for number, (name, simulation) in enumerate(list(first.world.cars.items())[1:], 2):
        one = copy.copy(first)
        one.number, one.simulation, one.ego = number, simulation, "/carla/" + name
        one.values = copy.copy(first.values)
        one.values.role_name, one.drive_log = name, None
        one.values.picture_feed += "_" + name
        one.pictures = first.pictures and first.pictures._replace(role_name=name)
        yield one
