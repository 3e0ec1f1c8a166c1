"""Parameters of the sim node, and the simulation that they describe."""

from __future__ import annotations

import importlib
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import rospy

from sdc_common.geometry.road_line import road_route
from sdc_common.geometry.route import Route
from sdc_common.ros.node import parameter, refuse
from sdc_common.routes.waypoint_file import WaypointError, load_waypoints
from sdc_common.validation import DocumentError, suggestion
from sdc_sim.physics.vehicle_parameters import VehicleParameters
from sdc_sim.ros.bridge_versions import BRIDGE_VERSIONS
from sdc_sim.ros.drive_log import DriveLog
from sdc_sim.ros.picture_feed import PictureSettings
from sdc_sim.scenario.configuration import build_simulation, checked, sensors_that_are_on
from sdc_sim.simulation.simulation import OccupiedError
from sdc_sim.yaml_document import packaged_config

# Parameters of the node besides those of config/sim.yaml.
_OF_NODE = ("sync", "camera", "picture_feed")
_PATHS = ("waypoints_path", "obstacles_path", "vehicles_folder")


def _parameters() -> dict[str, Any]:
    """Return all parameters; with one that is missing, unknown or not valid the node ends."""
    known = [*packaged_config("sim"), *_OF_NODE, *_PATHS]
    # One call for all: rospy hangs if it gets a signal during a call to the master.
    values = rospy.get_param("~", {})
    for name in sorted(set(values) - set(known)):
        hint = suggestion(name, known, "remove it")
        refuse(f"unknown parameter {rospy.resolve_name('~' + name)}; {hint}")
    try:
        return {
            name: checked(name, values[name] if name in values else parameter(name))
            for name in known
        }
    except ValueError as error:
        refuse(f"{error}; fix it in config/sim.yaml")


class SimulationSetup:
    """Reads and checks all parameters; with an invalid one the node ends with one line."""

    def __init__(self) -> None:
        parameters = _parameters()
        # The parameters by their names in config/sim.yaml.
        self.values = values = SimpleNamespace(**parameters)
        self.ego = f"/carla/{values.role_name}"  # prefix of the topics of the vehicle
        self.number = 1  # id of the vehicle; the first one has the topics of the world, too
        # Whether any topic has the true state of the vehicle, or the map.
        self.shows_truth = values.ground_truth or values.truth
        self.bridge = BRIDGE_VERSIONS[values.bridge]
        several: Any = None  # imported for several cars only
        if values.cars > 1:
            several = importlib.import_module("sdc_sim.scenario.several_cars")
        try:
            self.route_m: np.ndarray = load_waypoints(values.waypoints_path)
            self.route = road_route(self.route_m)
            self.sensors = sensors_that_are_on(parameters)
            build: Any = several.build_world if several else build_simulation
            self.world = build(parameters, self.route, self.route_m)
            self.simulation = self.world.first if several else self.world
            self.drive_log = DriveLog(values.drive_log) if values.drive_log else None
        except (WaypointError, DocumentError, OccupiedError) as error:
            refuse(error)
        except ValueError as error:
            refuse(f"{error}; fix it in config/sim.yaml")
        except OSError as error:
            fix = "name a file in a folder that can be written"
            refuse(f"drive_log: {error.filename}: {error.strerror}; {fix}")
        self.pictures = None  # what the pictures have in common; None without a camera
        if values.camera:
            self.pictures = PictureSettings(
                values.waypoints_path,
                values.map_path,
                values.role_name,
                values.bridge,
                values.daylight,
                values.weather,
                values.sync,
            )
        self.cars: list[SimulationSetup] = several.setups(self) if several else [self]
        _warn_of_tight_bends(self.route, self.simulation.vehicle.parameters, values.waypoints_path)


def _warn_of_tight_bends(route: Route, vehicle: VehicleParameters, path: str) -> None:
    """Log the tightest bend if the vehicle cannot steer along it."""
    least_m = vehicle.wheelbase_m / math.tan(vehicle.full_wheel_angle_rad(0.0))
    tightest = int(np.argmax(np.abs(route.curvature)))
    radius_m = 1.0 / max(abs(float(route.curvature[tightest])), 1e-9)
    if radius_m < least_m:
        x_m, y_m = route.points[tightest]
        rospy.logwarn(
            "sim: %s: the bend at (%.1f, %.1f) has a radius of %.1f m, and the vehicle cannot turn "
            "on less than %.1f m: it will leave the route there",
            *(path, x_m, y_m, radius_m, least_m),
        )
