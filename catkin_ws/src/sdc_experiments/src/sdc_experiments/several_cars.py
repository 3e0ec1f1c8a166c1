"""Drive several cars in one world in one process: `drive_cars("", cars=3)`.

The drives and their reports are those of ./drive cars:=3 in lockstep, bit for bit.
"""

from __future__ import annotations

from typing import Any, Callable, Mapping

from sdc_experiments.closed_loop import car_with, evaluation_rules, own_planner
from sdc_experiments.configuration import node_parameters
from sdc_experiments.recorder import DriveRecorder, stop_lines_of
from sdc_sim.evaluation.drive_evaluation import DriveEvaluation
from sdc_sim.scenario.drive_setup import RouteSource, drive_setup
from sdc_sim.scenario.packaged import overridden
from sdc_sim.simulation.loop import Driver
from sdc_sim.simulation.shared_world import race
from sdc_sim.simulation.snapshot import Snapshot


def drive_cars(  # noqa: PLR0913  all by name, as those of ./drive
    scenario: str = "",
    *,
    cars: int = 2,
    route: RouteSource | None = None,
    drivers: Mapping[str, Driver] | None = None,
    sim_options: Mapping[str, Any] | None = None,
    planner_options: Mapping[str, Any] | None = None,
    referee_options: Mapping[str, Any] | None = None,
    longest_s: float | None = None,
    observe: Callable[[Mapping[str, Snapshot]], Any] | None = None,
) -> dict[str, DriveEvaluation]:
    """Drive until the drives of all cars have ended; return their evaluations by name.

    Args:
        scenario: name or path of a scenario, "" for the route alone; without a map
        cars: number of cars, up to 8
        route: as that of `drive_result`
        drivers: what drives a car, by its name; others have planner and controller of sdc_package
        sim_options: parameters that replace those of sdc_sim/config/sim.yaml
        planner_options: the same for sdc_package/config/local_planner.yaml
        referee_options: the same for sdc_sim/config/referee.yaml
        longest_s: simulated time after which to stop, None for no limit but the referee's [s]
        observe: called in each tick with the true states of the cars that drive, by name

    Raises:
        ValueError: an argument or a file is not valid; the message is one line that names it
    """
    setup = drive_setup(scenario, route, {**(sim_options or {}), "cars": cars})
    limits = overridden(node_parameters("local_planner"), planner_options or {}, "planner_options")
    rules = evaluation_rules(limits, referee_options or {})
    world = setup.world()
    by_name = drivers or {}
    lines, seen = stop_lines_of(world.first.lights), world.first.observation
    plan = limits, setup.waypoints_m, lines, None, seen
    drivers = {name: by_name.get(name) or car_with(own_planner(*plan)[0]) for name in world.cars}
    recorders = {
        name: DriveRecorder(rules, setup.waypoints_m, car) for name, car in world.cars.items()
    }
    race(world, drivers, recorders, longest_s, observe)
    return {name: recorder.evaluator.result() for name, recorder in recorders.items()}
