"""Drive a scenario with planner and controller in one process: `drive("slalom")`.

The drive and its report are those of ./drive in lockstep, bit for bit; docs/python_api.md has
examples.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Callable, Mapping, Sequence, Union, cast

import numpy as np

from sdc_common.configuration import node_config
from sdc_common.driving import Observation, Path, points_as_sent
from sdc_common.geometry.segments import use_machine_code
from sdc_common.planning.stop_line import StopLine
from sdc_experiments.configuration import node_parameters, planner_parameters
from sdc_experiments.recorder import DriveRecorder, stop_lines_of
from sdc_package.behaviour.street_planner import StreetPlanner
from sdc_package.car import Car, MissionDriver, PathPlanner
from sdc_package.controller import Controller
from sdc_package.planner_settings import PlannerSettings
from sdc_package.steering.axles import Axles
from sdc_package.steering.loader import load_steering, section_of
from sdc_package.steering.method import Steering
from sdc_package.street_settings import StreetSettings
from sdc_package.traffic_lights import TrafficLightMonitor
from sdc_sim.evaluation.drive_evaluation import DriveEvaluation
from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.evaluation.rules import EvaluationRules
from sdc_sim.scenario.drive_setup import RouteSource, drive_setup
from sdc_sim.scenario.packaged import overridden
from sdc_sim.simulation import loop
from sdc_sim.simulation.snapshot import Snapshot

if TYPE_CHECKING:
    from sdc_map.global_planner import GlobalPlanner

_NO_OPTIONS: Mapping[str, Any] = {}

# Rows (x, y, target speed) of the path ahead [m, m, m/s]; OffRouteError if there is none.
PlannerFunction = Callable[[Observation], Union[Path, Sequence[Sequence[float]]]]
# A name of config/simple_controller.yaml, a method, or a function like Steering.wheel_angle.
SteeringSource = Union[str, Steering, Callable[..., float]]
# What a car can lack, and what its planner sees in place of fields of the observation: road users
# or lights; decisions on streets (signs) or those to leave its lane (behaviour); limits of speed.
LACKS: dict[str, dict] = {"obstacles": {"obstacles": ()}, "lights": {"light_states": {}}}
LACKS.update({name: {} for name in ("signs", "behaviour", "speed", "")})
_FAST = {"lateral_acceleration_mps2": 30.0, "planned_speed_mps": 20.0}


def drive(scenario: str = "", **arguments: Any) -> dict[str, Any]:
    """Drive, and return the content of report.json; see `drive_result` for the arguments."""
    return drive_result(scenario, **arguments).metrics


def drive_result(  # noqa: PLR0913  all by name, as those of ./drive
    scenario: str = "",
    *,
    route: RouteSource | None = None,
    map: str = "",  # noqa: A002  the name of the argument of ./drive
    start: Sequence[float] | None = None,
    goal: Sequence | None = None,
    steering: SteeringSource | None = None,
    planner: PlannerFunction | None = None,
    seed: int | None = None,
    traffic: int | None = None,
    sim_options: Mapping[str, Any] = _NO_OPTIONS,
    planner_options: Mapping[str, Any] = _NO_OPTIONS,
    controller_options: Mapping[str, Any] = _NO_OPTIONS,
    referee_options: Mapping[str, Any] = _NO_OPTIONS,
    longest_s: float | None = None,
    observe: Callable[[Snapshot], Any] | None = None,
    watch: Callable[[Evaluator], Any] | None = None,
    compiled: bool = False,
    lacking: str = "",
) -> DriveEvaluation:
    """Drive until the drive ends, and return its evaluation.

    Args:
        scenario: name of a packaged scenario or path of a scenario file, "" for the route alone
        route: the route, in place of that of the scenario: the path of a waypoint file, an array of
            (x, y) in the map [m], or a list of straights and bends. Without both it is the town
        map: path of a map, on which the car finds its route, in place of `route`
        start: (x, y) on the map [m]; None to draw it from the seed
        goal: (x, y) on the map, or a list of them [m]; None to draw one from the seed
        steering: name of a steering method, an object with a method `wheel_angle`, or a function
            with its arguments; None for that of config/simple_controller.yaml
        planner: returns rows (x, y, target speed) for an observation; None for the local planner
        seed: seed of noise and traffic, in place of that of the scenario
        traffic: number of other road users on the map, also in its place
        sim_options: parameters that replace those of sdc_sim/config/sim.yaml
        planner_options: the same for local_planner.yaml of sdc_package, and on a map for
            street_planner.yaml
        controller_options: the same for sdc_package/config/simple_controller.yaml
        referee_options: the same for sdc_sim/config/referee.yaml
        longest_s: simulated time after which to stop, None for no limit but the referee's [s]
        observe: called with the true state of the world in each tick
        watch: called with the evaluator after each tick
        compiled: compute in machine code where Numba is installed; it pays after half an hour
        lacking: what the car lacks, see LACKS

    Raises:
        ValueError: an argument or a file is not valid; the message names it
    """
    if compiled:
        use_machine_code()
    own = {"seed": seed, "traffic": traffic}.items()
    options = {**sim_options, **{name: value for name, value in own if value is not None}}
    setup = drive_setup(scenario, route, options, map, start, goal)
    missions = setup.missions
    world = setup.simulation(compiled)
    limits = _limits(planner_options, lacking, missions is not None)
    known = stop_lines_of(world.lights), missions, world.observation, lacking
    chosen, waypoints_m = own_planner(limits, setup.waypoints_m, *known)
    car = car_with(function_planner(planner) if planner else chosen, steering, controller_options)
    on_map = {"map": setup.parameters["map_path"], "new_missions": missions is not None}
    rules = evaluation_rules(limits, {**on_map, **referee_options})
    recorder = DriveRecorder(rules, waypoints_m, world, watch)
    if missions is not None:
        missions.on_mission = lambda new: recorder.evaluator.set_route(points_as_sent(new.points_m))
    loop.drive(world, car, recorder, longest_s, observe)
    return recorder.evaluator.result()


def _limits(options: Mapping[str, Any], lacking: str, on_map: bool) -> dict[str, Any]:
    """Return the parameters of the local planner."""
    if lacking not in LACKS:
        raise ValueError(f"lacking: must be one of {', '.join(LACKS)[:-2]}, got '{lacking}'")
    options = {**options, **(_FAST if lacking == "speed" else {})}
    return overridden(planner_parameters(on_map), options, "planner_options")


def own_planner(
    limits: Mapping[str, Any],
    waypoints_m: np.ndarray,
    lines: Mapping[int, StopLine],
    missions: GlobalPlanner | None,
    seen: Observation,
    lacking: str = "",
) -> tuple[PathPlanner, np.ndarray]:
    """Return the local planner of a car without what it lacks, and its first waypoints."""
    settings = PlannerSettings.read(limits.__getitem__)
    if missions is None:
        return MissionDriver(waypoints_m, settings, lines), waypoints_m
    mission = missions.update(seen.x_m, seen.y_m, seen.yaw_rad, seen.z_m)
    assert mission is not None
    points_m = mission.points_m
    road_mps = None if lacking == "speed" else mission.limits_mps
    if lacking == "signs":
        return MissionDriver(points_m, settings, lines, missions, road_mps), points_m
    lights = TrafficLightMonitor(settings.traffic_lights)
    lights.lines = dict(lines)
    keeps_route = lacking == "behaviour"
    rules = StreetSettings.read(limits.__getitem__)
    driver = StreetPlanner(missions.network, rules, lights, missions, keeps_route)
    driver.follow(points_m, road_mps)
    if not LACKS[lacking]:
        return driver, points_m
    return function_planner(lambda view: driver.plan(replace(view, **LACKS[lacking]))), points_m


def car_with(
    planner: PathPlanner,
    steering: SteeringSource | None = None,
    options: Mapping[str, Any] = _NO_OPTIONS,
) -> Car:
    """Return a car with the controller of config/simple_controller.yaml.

    `steering` and `options` replace the steering method and parameters of the file.

    Raises:
        ValueError: the steering method cannot be built, or a parameter is not valid
    """
    return Car(planner, *controller_with(steering, options))


def controller_with(
    steering: SteeringSource | None = None, options: Mapping[str, Any] = _NO_OPTIONS
) -> tuple[Controller, float]:
    """Return the controller of `car_with`, and its timeout of the path [s]."""
    config = node_parameters("simple_controller")
    method: Any = options.get("steering_method", config["steering_method"])
    method = method if steering is None else steering
    section = section_of(method) if isinstance(method, str) else ""
    if section not in config and section in options:
        # The section of a method that is not one of this project.
        config[section] = options[section]
        options = {name: value for name, value in options.items() if name != section}
    config = overridden(config, options, "controller_options")
    if isinstance(method, str):
        method = load_steering(method, config.get(section), Axles(**config["axles"]))
    elif not hasattr(method, "wheel_angle"):
        if not callable(method):
            raise ValueError(
                "steering: must be a name, an object with a method wheel_angle or a function, "
                f"got {method!r}"
            )
        method = SimpleNamespace(wheel_angle=method)
    return Controller(config.__getitem__, method), config["patience_s"]


def evaluation_rules(
    planner_limits: Mapping[str, Any], options: Mapping[str, Any] = _NO_OPTIONS
) -> EvaluationRules:
    """Return the rules of config/referee.yaml, with options that replace some of them.

    The parameters of the planner give the ideal duration.

    Raises:
        ValueError: an option is not valid
    """
    config = overridden(node_config("sdc_sim", "referee"), options, "referee_options")
    rules = EvaluationRules.read(config.__getitem__)
    planner = {name: planner_limits[name] for name in rules.planner}
    return rules._replace(planner=planner, assumed=[])


def function_planner(function: PlannerFunction) -> PathPlanner:
    """Return a function as a planner."""

    def plan(observation: Observation) -> Path:
        rows: Any = function(observation)
        try:
            points = rows.points if isinstance(rows, Path) else [(x, y, v) for x, y, v in rows]
        except (TypeError, ValueError):
            raise TypeError(f"plan must return rows x, y, v or a Path, got {rows!r}") from None
        return Path(points)

    return cast("PathPlanner", SimpleNamespace(reason="", detail="", plan=plan))
