"""A world of several cars, and the setup of each in the sim node: docs/several_cars.md."""

from __future__ import annotations

import copy
from typing import Any, Mapping

import numpy as np

from sdc_common.geometry.route import Route
from sdc_common.validation import DocumentError
from sdc_sim.scenario.configuration import build_simulation
from sdc_sim.simulation.shared_world import SharedWorld

# What is for one car alone: a parameter, its value without it, and why.
_FOR_ONE_CAR = (
    ("traffic", 0, "SUMO moves its road users around one car"),
    ("street_scenario", "", "a scenario type is about one car"),
    ("truth", True, "the estimate of the position is that of one car"),
)


def names_of_cars(count: int, first: str = "ego_vehicle") -> list[str]:
    """Return the names of cars in their topics, as the CARLA bridge names them."""
    return [first, *(f"hero{number}" for number in range(1, count))]


def build_world(
    values: Mapping[str, Any],
    route: Route,
    waypoints_m: np.ndarray,
) -> SharedWorld:
    """Return a world of several cars at its start.

    Each car has obstacles, lights, sensors and noise as a car alone, the noise with another seed.

    Args:
        values: as those of `build_simulation`, with `cars` and `next_car`
        route: the road, at whose end cars arrive
        waypoints_m: as that of `build_simulation`

    Raises:
        DocumentError: a file is not valid, or a parameter is for one car alone
        OccupiedError: a car starts where an obstacle or another car is
        ValueError: a place is not on the route
    """
    for name, without, reason in _FOR_ONE_CAR:
        if values[name] != without:
            raise DocumentError(f"{name}: not with cars:={values['cars']}, because {reason}")
    cars, step = {}, values["next_car"]
    for number, name in enumerate(names_of_cars(values["cars"], values["role_name"])):
        start = {key: value + number * step.get(key, 0.0) for key, value in values["start"].items()}
        own = {**values, "start": start, "seed": values["seed"] + number}
        cars[name] = build_simulation(own, route, waypoints_m)
        if any(len(obstacle.plan.points_m) > 1 for obstacle in cars[name].obstacles.all):
            fix = "an obstacle that moves reacts to one car; let it stand still"
            raise DocumentError(f"obstacles: not with cars:={values['cars']}: {fix}")
    x_m, y_m = route.points[-1].tolist()
    return SharedWorld(cars, (x_m, y_m))


def setups(first: Any) -> list[Any]:
    """Return the SimulationSetup of the first car, and those of the other cars of its world."""
    found = [first]
    for name, simulation in list(first.world.cars.items())[1:]:
        setup = copy.copy(first)
        setup.number, setup.simulation, setup.ego = len(found) + 1, simulation, "/carla/" + name
        setup.values = copy.copy(first.values)
        setup.values.role_name, setup.drive_log = name, None
        setup.values.picture_feed += "_" + name
        setup.pictures = first.pictures and first.pictures._replace(role_name=name)
        found.append(setup)
    return found
