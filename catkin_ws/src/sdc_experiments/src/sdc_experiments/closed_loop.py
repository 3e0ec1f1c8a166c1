"""Drive a scenario with planner and controller in one process: `drive("slalom")`.

The drive and its report are those of ./drive in lockstep, bit for bit; docs/python_api.md has
examples.
"""

from __future__ import annotations

from typing import Any, Callable, Mapping

from sdc_common.geometry.segments import use_machine_code
from sdc_common.ros.stop_lines import stop_lines
from sdc_experiments.car_stack import (
    CarController,
    CarPlanner,
    Planner,
    Rows,
    SteeringSource,
    mission_of,
    pose_and_speed,
)
from sdc_package.local_planner import OffRouteError
from sdc_sim.evaluation.drive_evaluation import DriveResult
from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.evaluation.rules import EvaluationRules
from sdc_sim.physics.vehicle import VehicleCommand
from sdc_sim.ros.message_conversion import light_info_message
from sdc_sim.scenario.drive_setup import DriveSetup, RouteSource, drive_setup
from sdc_sim.scenario.packaged import node_config, overridden
from sdc_sim.simulation.simulation import Observation, Simulation

_NO_OPTIONS: Mapping[str, Any] = {}
_NS_PER_S = 1_000_000_000


def drive(scenario: str = "", **arguments: Any) -> dict[str, Any]:
    """Drive, and return the content of report.json; see `drive_result` for the arguments."""
    return drive_result(scenario, **arguments).metrics


def drive_result(
    scenario: str = "",
    *,
    route: RouteSource | None = None,
    steering: SteeringSource | None = None,
    planner: Planner | None = None,
    seed: int | None = None,
    sim_options: Mapping[str, Any] = _NO_OPTIONS,
    planner_options: Mapping[str, Any] = _NO_OPTIONS,
    controller_options: Mapping[str, Any] = _NO_OPTIONS,
    referee_options: Mapping[str, Any] = _NO_OPTIONS,
    longest_s: float | None = None,
    observe: Callable[[Observation], Any] | None = None,
    compiled: bool = False,
) -> DriveResult:
    """Drive until the drive ends, and return its evaluation.

    Args:
        scenario: name of a packaged scenario or path of a scenario file, "" for the route alone
        route: the route, in place of that of the scenario: the path of a waypoint file, an array of
            (x, y) in the map [m], or a list of straights and bends. Without both it is the town
        steering: name of a steering method, an object with a method `wheel_angle`, or a function
            with its arguments; None for that of config/simple_controller.yaml
        planner: a function of the observation that returns rows (x, y, target speed) of the path
            ahead; None for the local planner
        seed: seed of the noise, in place of that of the scenario
        sim_options: parameters that replace those of sdc_sim/config/sim.yaml
        planner_options: the same for sdc_package/config/local_planner.yaml
        controller_options: the same for sdc_package/config/simple_controller.yaml
        referee_options: the same for sdc_sim/config/referee.yaml
        longest_s: simulated time after which to stop, None for no limit but the referee's [s]
        observe: called with each observation, which also has the true state of the vehicle
        compiled: compute the vehicle and the lines in machine code where Numba is installed, which
            gives the same numbers; it pays after half an hour of simulated drives

    Raises:
        ValueError: an argument, a name, a file or an option is not valid; the message is one line
            that names it
    """
    if compiled:
        use_machine_code()
    options = dict(sim_options) if seed is None else {**sim_options, "seed": seed}
    setup = drive_setup(scenario, route, options)
    simulation = setup.simulation(compiled)
    own_planner = CarPlanner(setup.waypoints_m, planner_options, simulation.lights)
    controller = CarController(steering, controller_options)
    evaluation = DriveRecorder(setup, simulation, own_planner.parameters, referee_options)
    plan: Planner = own_planner if planner is None else planner
    reason = (lambda: own_planner.reason) if planner is None else (lambda: "")
    drive_until_over(
        simulation,
        plan,
        controller,
        evaluation,
        reason=reason,
        longest_s=longest_s,
        observe=observe,
    )
    return evaluation.result()


class Recorder:
    """Ends a drive, and records nothing of it."""

    def add(self, observation: Observation) -> bool:
        """Add an observation; return whether the drive is over."""
        raise NotImplementedError

    def add_answer(
        self, observation: Observation, command: VehicleCommand, rows: Rows, reason: str
    ) -> None:
        """Add the command and the path that answer an observation."""
        return

    def add_stop(self, observation: Observation, command: VehicleCommand) -> None:
        """Add the command of a controller without a path, which carries no stamp."""
        return


def drive_until_over(
    simulation: Simulation,
    plan: Planner,
    controller: CarController,
    recorder: Recorder,
    *,
    believe: Callable[[Observation], Observation] = lambda observation: observation,
    reason: Callable[[], str] = lambda: "",
    longest_s: float | None = None,
    observe: Callable[[Observation], Any] | None = None,
) -> None:
    """Drive tick by tick until the drive ends.

    Args:
        simulation: the simulation at its start
        plan: plans the path ahead
        controller: follows the path
        recorder: gets the true observations, and ends the drive
        believe: returns the observation that the car plans and steers by
        reason: returns what limits the speed of the last path
        longest_s: see drive_result
        observe: see drive_result
    """
    observation = simulation.observation
    while True:
        if observe is not None:
            observe(observation)
        over = recorder.add(observation)
        over = over or (longest_s is not None and simulation.elapsed_s >= longest_s)
        believed = believe(observation)
        command: VehicleCommand | None
        try:
            rows = plan(believed)
        except OffRouteError:
            command = controller.stop(believed)
            if command is not None:
                recorder.add_stop(observation, command)
        else:
            command = controller(believed, rows)
            recorder.add_answer(observation, command, rows, reason())
        if over:
            return
        observation = simulation.step(command)


class DriveRecorder(Recorder):
    """Evaluates a drive in process as the referee does.

    Args:
        setup: the conditions of the drive
        simulation: its simulation
        planner_parameters: parameters of the local planner, which give the ideal duration
        options: parameters that replace those of config/referee.yaml

    Raises:
        ValueError: an option is not valid
    """

    def __init__(
        self,
        setup: DriveSetup,
        simulation: Simulation,
        planner_parameters: Mapping[str, Any],
        options: Mapping[str, Any] = _NO_OPTIONS,
    ):
        config = overridden(node_config("sdc_sim", "referee"), options, "referee_options")
        rules = EvaluationRules.read(config.__getitem__)
        planner = {name: planner_parameters[name] for name in rules.planner}
        self.evaluator = Evaluator(rules._replace(planner=planner, assumed=[]))
        self.evaluator.set_route(mission_of(setup.waypoints_m))
        lights = simulation.lights
        if lights.plans:
            info = light_info_message(lights.plans, lights.states(0.0))
            self.evaluator.set_stop_lines(stop_lines(info))
        for obstacle in simulation.observation.obstacles:
            self.evaluator.add_obstacle(obstacle.id, obstacle.kind)

    def add(self, observation: Observation) -> bool:
        """Add an observation; return whether the drive is over."""
        evaluator, stamp_ns = self.evaluator, stamp_nanoseconds(observation)
        evaluator.add_odometry(stamp_ns, *pose_and_speed(observation))
        if observation.traffic_lights:
            states = {light.id: light.state for light in observation.traffic_lights}
            evaluator.set_lights(stamp_ns, states)
        for collision in observation.collisions:
            evaluator.add_collision(stamp_ns, collision.id)
        return evaluator.over

    def add_answer(
        self, observation: Observation, command: VehicleCommand, rows: Rows, reason: str
    ) -> None:
        """Add the command and the path that answer an observation."""
        stamp_ns = stamp_nanoseconds(observation)
        self.evaluator.add_command(stamp_ns, command.throttle, command.brake, command.steer)
        self.evaluator.add_planned_speed(rows[0][2])
        if reason:
            self.evaluator.add_reason(stamp_ns, reason)

    def add_stop(self, observation: Observation, command: VehicleCommand) -> None:
        """Add the command of a controller without a path, which carries no stamp."""
        self.evaluator.add_command(0, command.throttle, command.brake, command.steer)
        self.evaluator.add_reason(stamp_nanoseconds(observation), "path_timeout")

    def result(self) -> DriveResult:
        """Return the evaluated drive."""
        return self.evaluator.result()


def stamp_nanoseconds(observation: Observation) -> int:
    """Return the time of an observation [ns]."""
    seconds, nanoseconds = observation.stamp
    return seconds * _NS_PER_S + nanoseconds
