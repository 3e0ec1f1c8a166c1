"""What a drive in process needs: the scenario, its route, and the simulation of both."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Mapping, Sequence, Union

import numpy as np

from sdc_common.configuration import node_config
from sdc_common.geometry.road_line import road_route
from sdc_common.geometry.route import Route, checked_points
from sdc_common.routes.waypoint_file import LARGEST_COORDINATE_M, load_waypoints, parse_waypoints
from sdc_common.validation import DocumentError
from sdc_sim.physics.compiled_vehicle import CompiledVehicle
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.scenario.configuration import build_simulation, checked
from sdc_sim.scenario.packaged import (
    find_route,
    find_scenario,
    folder_of,
    generated_lines,
    overridden,
    sensor_options,
    sim_options,
)
from sdc_sim.scenario.reader import Scenario, load_scenario, map_path
from sdc_sim.scenario.several_cars import build_world
from sdc_sim.simulation.shared_world import SharedWorld
from sdc_sim.simulation.simulation import Simulation

if TYPE_CHECKING:
    from sdc_map.global_planner import GlobalPlanner

# The file or the name of a route, (N, 2) waypoints in the map [m], or straights and bends.
RouteSource = Union[str, np.ndarray, Sequence[Mapping]]


@dataclass(frozen=True)
class DriveSetup:
    """The conditions of a drive."""

    scenario: Scenario | None  # the scenario, None for the route alone
    waypoints_m: np.ndarray  # (N, 2) waypoints of the mission in the map [m]
    route: Route = field(repr=False)  # the road along them
    parameters: dict[str, Any]  # parameters of config/sim.yaml for this drive
    missions: GlobalPlanner | None = field(default=None, repr=False)  # None without a map

    def simulation(self, compiled: bool = False) -> Simulation:
        """Return the simulation at its start, as the sim node builds it; see CompiledVehicle.

        Raises:
            ValueError: a parameter is not valid; the message names it
        """
        vehicle = CompiledVehicle if compiled else Vehicle
        return build_simulation(self._values(), self.route, self.waypoints_m, vehicle)

    def world(self) -> SharedWorld:
        """Return the world of several cars at its start, as the sim node builds it.

        Raises:
            ValueError: a parameter is not valid or is for one car alone; the message names it
        """
        return build_world(self._values(), self.route, self.waypoints_m)

    def _values(self) -> dict[str, Any]:
        return {
            **{name: checked(name, value) for name, value in self.parameters.items()},
            "vehicles_folder": folder_of("vehicle"),
            "obstacles_path": self.scenario.path if self.scenario is not None else "",
        }


def drive_setup(
    scenario: str = "",
    route: RouteSource | None = None,
    options: Mapping[str, Any] | None = None,
    map: str = "",  # noqa: A002  the name of the argument of ./drive
    start: Sequence[float] | None = None,
    goal: Sequence | None = None,
) -> DriveSetup:
    """Return the conditions of a drive, as ./drive reads them.

    Args:
        scenario: name of a packaged scenario or path of a scenario file, "" for the route alone
        route: replaces the route of the scenario; the packaged town route if neither has one
        options: parameters of config/sim.yaml, which override those of the scenario
        map: path of a map, on which the car finds its route, in place of `route`; without both, it
            is that of the scenario
        start: (x, y) on the map [m]; None to draw it from the seed
        goal: (x, y) on the map, or a list of them [m]; None for those of the scenario, or to draw
            one from the seed

    Raises:
        DocumentError, WaypointError: a name, a file or an option is not valid
        ValueError: the route is not valid
    """
    loaded = load_scenario(find_scenario(scenario)) if scenario else None
    # A path in a scenario is relative to its file, one of the caller to the working directory.
    place = os.path.join(os.getcwd(), "route")
    source: Any = route
    if route is None and loaded is not None:
        source, place = loaded.route, loaded.path
    parameters = node_config("sdc_sim", "sim")
    changes = options or {}
    if loaded is not None:
        parameters = overridden(parameters, sensor_options(loaded), loaded.path)
        changes = sim_options(loaded, changes)
    parameters = overridden(parameters, changes, "sim_options")
    seed, missions = parameters["seed"], None
    if loaded is not None and loaded.map is not None and route is None:
        map = map or map_path(loaded, seed)  # noqa: A001
        goal = goal or loaded.goals or None
    if map:
        from sdc_map.global_planner import GlobalPlanner
        from sdc_map.map_file import map_file
        from sdc_map.network_file import load_network
        from sdc_sim.scenario.map_drive import file_points, first_mission

        goals = () if goal is None else [goal] if np.ndim(goal) == 1 else goal
        parameters["map_path"] = map_file(map, seed=seed)
        missions = GlobalPlanner(load_network(parameters["map_path"]))
        types = parameters["street_scenario"]
        mission, goals = first_mission(missions.graph, start, goals, seed, types)
        missions.drive_to(goals)
        source = file_points(mission.points_m)
    waypoints_m = _waypoints("town" if source is None else source, place)
    return DriveSetup(loaded, waypoints_m, road_route(waypoints_m), parameters, missions)


def load_simulation(
    scenario: str = "",
    route: RouteSource | None = None,
    options: Mapping[str, Any] | None = None,
    **place: Any,
) -> Simulation:
    """Return the simulation of a scenario at its start, on its map; see `drive_setup`."""
    return drive_setup(scenario, route, options, **place).simulation()


def _waypoints(source: Any, scenario_path: str) -> np.ndarray:
    """Return the waypoints of a route, rounded as in the file that ./drive writes of it."""
    if isinstance(source, str):
        return load_waypoints(find_route(scenario_path, source))
    if isinstance(source, np.ndarray):
        points_m = checked_points(source)
        if np.abs(points_m).max() > LARGEST_COORDINATE_M:
            raise ValueError("route: a coordinate is beyond 100 km; write it in a local frame")
        return points_m
    if all(isinstance(element, Mapping) for element in source):
        lines = generated_lines([dict(element) for element in source])
        return parse_waypoints("".join(lines), "the generated route")
    raise DocumentError(
        "route: must be the name or path of a route, an array of (x, y), or a list of straights "
        "and bends"
    )
