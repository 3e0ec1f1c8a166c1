"""The evaluation of a drive in one process, which equals that of the referee."""

from __future__ import annotations

import math
from typing import Any, Callable, Sequence

import numpy as np

from sdc_common.driving import Command, points_as_sent, yaw_as_sent
from sdc_common.planning.stop_line import StopLine
from sdc_sim.evaluation.drive_evaluation import OBSTACLES
from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.evaluation.rules import EvaluationRules
from sdc_sim.physics.traffic_lights import LANE_WIDTH_M, TrafficLightPlan, light_states
from sdc_sim.simulation.loop import Driver
from sdc_sim.simulation.simulation import Simulation
from sdc_sim.simulation.snapshot import Snapshot, detected


class DriveRecorder:
    """Evaluates the ticks of `sdc_sim.simulation.loop.drive`, from the start of the world on.

    `watch` is called with the evaluator after each tick.
    """

    def __init__(
        self,
        rules: EvaluationRules,
        waypoints_m: np.ndarray,
        world: Simulation,
        watch: Callable[[Evaluator], Any] | None = None,
    ):
        self._watch = watch
        self.evaluator = Evaluator(rules)
        self.evaluator.set_route(points_as_sent(waypoints_m))
        if world.lights:
            lines = stop_lines_of(world.lights)
            self.evaluator.add("stop_lines", [(number, *line) for number, line in lines.items()])

    def add(self, snapshot: Snapshot, command: Command | None, car: Driver) -> bool:
        """Add a tick of the world and the car's answer; return whether the drive is over."""
        evaluator, stamp_ns, measured = self.evaluator, snapshot.stamp_ns, snapshot.measured
        yaw = yaw_as_sent(measured.yaw_rad, snapshot.pitch_rad)
        speed = math.hypot(measured.speed_mps, measured.lateral_speed_mps)
        pose = measured.x_m, measured.y_m, yaw
        evaluator.add("odometry", stamp_ns, *pose, speed, None, snapshot.z_m)
        if snapshot.traffic_lights:
            states = [(light.id, light.state) for light in snapshot.traffic_lights]
            evaluator.add("lights", stamp_ns, states)
        if evaluator.rules.map:
            seen = [list(vars(detected(obstacle)).values()) for obstacle in snapshot.obstacles]
            rows = [(number, *box, z, speed, kind) for *box, speed, number, kind, z in seen]
            evaluator.add("others", stamp_ns, rows)
        if snapshot.obstacles and evaluator.drive and evaluator.drive.is_scene_due(OBSTACLES):
            boxes = [[body.id, *body.rectangle[:5]] for body in snapshot.obstacles]
            evaluator.add("scene", OBSTACLES, None, boxes)
        kinds = {body.id: body.kind for body in snapshot.obstacles} if snapshot.collisions else {}
        for collision in snapshot.collisions:
            if collision.id in kinds:  # road users come and go during a drive
                evaluator.add("obstacle", collision.id, kinds[collision.id])
            evaluator.add("collision", stamp_ns, collision.id)
        if command is not None:
            pedals = command.throttle, command.brake
            evaluator.add("command", command.stamp_ns, *pedals, command.steer)
        if car.path is not None:
            evaluator.add("planned", car.path.points[0][2])
        if car.reason:
            evaluator.add("reason", stamp_ns, car.reason)
            evaluator.add("detail", stamp_ns, getattr(car, "detail", ""))
        if self._watch is not None:
            self._watch(evaluator)
        return evaluator.over


def stop_lines_of(plans: Sequence[TrafficLightPlan]) -> dict[int, StopLine]:
    """Return the stop line of each traffic light by its id, rounded as in the messages."""
    lines = {}
    for plan, light in zip(plans, light_states(plans, 0.0)):
        (ahead, left), yaw = plan.line_m(light), yaw_as_sent(light.heading_rad + math.pi)
        c, s = math.cos(yaw), math.sin(yaw)
        lines[light.id] = StopLine(
            light.x_m + c * ahead - s * left,
            light.y_m + s * ahead + c * left,
            0.5 * LANE_WIDTH_M,
            plan.z_m,
        )
    return lines
