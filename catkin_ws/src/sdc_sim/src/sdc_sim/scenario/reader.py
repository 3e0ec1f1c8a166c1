"""Read scenarios: the conditions of a drive and its acceptance limits."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any

from sdc_map.map_file import map_file
from sdc_sim.road.route_generator import RouteSpecError, curvature_profile
from sdc_sim.scenario.traffic import read_scenario
from sdc_sim.yaml_document import YamlDocument, schema


@dataclass(frozen=True)
class Scenario:
    """A drive as its file describes it; the module `traffic` reads what needs a route."""

    path: str  # the file
    about: str = ""  # one line for people
    # Elements of a generated route, or the name or path of a route; None if not given.
    route: str | list | None = None
    map: str | None = None  # path of a map, relative to the file; None if not given
    # Points (x, y) on the map, drawn from the seed if there is none [m]
    goals: list = field(default_factory=list)
    vehicle: str | None = None  # name of a vehicle preset; None if not given
    sensors: str | None = None  # name of a file of config/sensors; None if not given
    camera: bool = False  # whether tests render the camera
    sync: bool = True  # whether tests drive in lockstep
    sim: dict = field(default_factory=dict)  # options of config/sim.yaml
    # What the drive must keep, see acceptance_limits.violations.
    limits: dict = field(default_factory=dict)


def load_scenario(path: str) -> Scenario:
    """Read and validate a scenario.

    Raises:
        DocumentError: the file cannot be read or is not a valid scenario.
    """
    document = read_scenario(path)
    values = document.values
    _check_route(document, values.get("route"))
    if "goals" in values and "map" not in values:
        raise document.error(("goals",), "goals are places on a map; add the key map")
    options = schema("scenario")["definitions"]["sim"]
    sim = {key: values[key] for key in options if key in values}
    if "seed" in sim:
        sim["seed"] = int(sim["seed"])  # JSON schema accepts 7.0 as an integer
    names = {*Scenario.__dataclass_fields__} - {"path", "sim"}
    own = {key: values[key] for key in names if key in values}
    return Scenario(document.path, sim=sim, **own)


def map_path(scenario: Scenario, seed: int) -> str:
    """Return the path of the map of a scenario, which the seed of the drive may draw."""
    return map_file(scenario.map or "", os.path.dirname(os.path.abspath(scenario.path)), seed)


def _check_route(document: YamlDocument, route: Any) -> None:
    """Raise DocumentError for the first element with which the route cannot be generated."""
    for index in range(len(route) if isinstance(route, list) else 0):
        try:
            curvature_profile(route[: index + 1])
        except RouteSpecError as error:
            raise document.error(("route", index), str(error)) from None
