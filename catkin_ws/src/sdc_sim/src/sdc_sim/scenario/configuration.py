"""Build a simulation from the parameters of config/sim.yaml and the road of a scenario."""

from __future__ import annotations

import importlib
import math
import os
from dataclasses import replace
from functools import partial
from typing import Any, Mapping

import numpy as np

from sdc_common.geometry.route import Route
from sdc_common.validation import DocumentError
from sdc_sim.physics.ackermann import AckermannGains
from sdc_sim.physics.obstacles import Obstacles
from sdc_sim.physics.vehicle import Vehicle
from sdc_sim.physics.vehicle_parameters import load_vehicle
from sdc_sim.road.road import Road
from sdc_sim.road.scenery import Scenery
from sdc_sim.scenario.traffic import load_traffic
from sdc_sim.sensors.errors import OdometryNoise
from sdc_sim.sensors.model import SENSORS, SensorSettings, sensor_settings
from sdc_sim.sensors.suite import SensorSuite
from sdc_sim.simulation.simulation import Simulation
from sdc_sim.yaml_document import check_parameter, packaged_config, schema


def checked(name: str, value: Any) -> Any:
    """Return the value of a parameter of config/sim.yaml.

    Raises:
        ValueError: it is not valid by config/schemas; the message names the parameter
    """
    schemas = {**schema("scenario")["properties"], **schema("sim")}
    if name in schemas:
        check_parameter(name, value, schemas[name])
    return value


def build_simulation(
    values: Mapping[str, Any],
    route: Route,
    waypoints_m: np.ndarray,
    vehicle_class: type[Vehicle] = Vehicle,
) -> Simulation:
    """Return a simulation at its start.

    Args:
        values: the parameters of config/sim.yaml, checked, and those of sim.launch:
            vehicles_folder, and obstacles_path, the scenario ("" for none)
        route: the road
        waypoints_m: (N, 2) waypoints along which its scenery is placed [m]
        vehicle_class: Vehicle, or CompiledVehicle

    Raises:
        DocumentError: a file is not valid
        OccupiedError: an obstacle is at the start pose
        ValueError: a place is not on the route
    """
    obstacles, lights = load_traffic(values["obstacles_path"], route, values["map_path"])
    ground = None
    if values["map_path"]:
        load_network = importlib.import_module("sdc_map.network_file").load_network
        ground = load_network(values["map_path"]).ground
    if ground:
        heights = [ground(light.x_m, light.y_m, light.heading_rad)[0] for light in lights]
        lights = [replace(light, z_m=height) for light, height in zip(lights, heights)]
    tick_s, seed, type_name = values["tick_s"], values["seed"], values["street_scenario"]
    lights, traffic = [*lights, *part_of_map("traffic.lights", values["map_path"])], None
    for name in ("traffic", "street_scenario"):
        if values[name] and not values["map_path"]:
            raise DocumentError(f"{name}: other road users need streets; name a map (map:=FILE)")
    if type_name:
        placed = part_of_map("scenario.street_scenarios", values["map_path"], type_name, seed)
        lights = [replace(light, offset_s=light.offset_s + placed.lights_s) for light in lights]
        values = {**values, **placed.parameters}
    vehicle = _vehicle(values, vehicle_class)
    if type_name:
        arguments: tuple = placed.actors, placed.mission_m, seed, tick_s, lights, ground
        traffic = importlib.import_module("sdc_sim.traffic.actors").ScriptedTraffic(*arguments)
    elif values["traffic"]:
        arguments = values["map_path"], values["traffic"], seed, tick_s, waypoints_m
        traffic = part_of_map("traffic.sumo_traffic", *arguments)
    sensors = sensors_that_are_on(values)
    scenery = partial(_scenery, values["map_path"], waypoints_m)
    known = vehicle.parameters, tick_s, seed, route, scenery
    suite = SensorSuite(sensors, *known) if sensors else None
    return Simulation(
        vehicle,
        tick_s,
        values["command_patience_s"],
        start=start_pose(route, **values["start"]),
        obstacles=Obstacles(obstacles, ground),
        lights=lights,
        noise=OdometryNoise(seed, **values["odometry_noise"]),
        ackermann=AckermannGains(**{**packaged_config("sim")["ackermann"], **values["ackermann"]}),
        command_latency_s=values["command_latency_s"],
        sensor_latency_s=values["sensor_latency_s"],
        sensors=suite,
        traffic=traffic,
        ground=ground,
    )


def _vehicle(values: Mapping[str, Any], vehicle_class: type[Vehicle]) -> Vehicle:
    path = os.path.join(values["vehicles_folder"], values["vehicle"] + ".yaml")
    parameters, factors = load_vehicle(path), values["vehicle_factors"]
    changed = {name: factor * getattr(parameters, name) for name, factor in factors.items()}
    conditions = values["friction"], values["side_wind_mps"]
    return vehicle_class(replace(parameters, **changed), *conditions)


def _scenery(map_path: str, waypoints_m: np.ndarray) -> Scenery:
    return part_of_map("road.network_scenery", map_path) or Road(waypoints_m).scenery()


def part_of_map(module: str, map_path: str, *arguments: Any) -> Any:
    """Return what a module of sdc_sim makes of a map; without a map it is not imported."""
    if not map_path:
        return ()
    return importlib.import_module("sdc_sim." + module).of_map(map_path, *arguments)


def sensors_that_are_on(values: Mapping[str, Any]) -> dict[str, SensorSettings]:
    """Return the settings of the sensors with a period, by name."""
    settings = {name: sensor_settings(name, values[name]) for name in SENSORS}
    return {name: sensor for name, sensor in settings.items() if sensor.period_s > 0.0}


def start_pose(
    route: Route, along_m: float, left_m: float, turned_rad: float
) -> tuple[float, float, float]:
    """Return the pose (x [m], y [m], yaw [rad]) at a place relative to the route.

    Raises:
        ValueError: the place is not on the route
    """
    if not 0.0 <= along_m <= route.length_m:
        raise ValueError(
            f"start along_m must be from 0 to the route's {route.length_m:.1f} m, got {along_m}"
        )
    x, y = route.line.point_at(along_m)
    direction = route.line.direction_at(along_m)
    return (
        x - left_m * math.sin(direction),
        y + left_m * math.cos(direction),
        direction + turned_rad,
    )
