"""One drive of a driver: the world steps, the driver answers, and what is late acts late."""

from __future__ import annotations

import hashlib
import math
from collections import deque
from dataclasses import replace
from typing import Any

import numpy as np

from sdc_common.driving import Command, Observation, Path
from sdc_experiments.championship.driver_process import DriverError, DriverProcess, DriverServer
from sdc_experiments.championship.league import LEAGUES, TABLE, Draw, draw, prepared
from sdc_experiments.championship.score import points, score, values
from sdc_experiments.closed_loop import evaluation_rules
from sdc_experiments.recorder import DriveRecorder
from sdc_sim.evaluation.drive_evaluation import DriveEvaluation
from sdc_sim.evaluation.rules import EvaluationRules
from sdc_sim.physics.ackermann import AckermannTarget
from sdc_sim.simulation import loop
from sdc_sim.simulation.simulation import Simulation
from sdc_sim.simulation.snapshot import Snapshot

_NS_PER_MS = 1_000_000


class Lateness:
    """When the answers of a driver act, whose core computes one after the other.

    Args:
        tick_ns: duration of a tick [ns]
        record: entries of an earlier drive to repeat, None to measure

    Attributes:
        record: tick of the observation, tick at which the answer acts, and tick of the next
            observation, of each step that was late
    """

    def __init__(self, tick_ns: int, record: list[list[int]] | None = None):
        self._tick_ns, self._given_ns = tick_ns, round(TABLE["step_cpu_ms"] * _NS_PER_MS)
        self._repeated = None if record is None else {row[0]: row[1:] for row in record}
        self._free_ns = 0
        self.record: list[list[int]] = []

    def step(self, tick: int, spent_ns: int) -> tuple[int, int]:
        """Return when the answer to a tick acts, and which observation the driver gets next."""
        self._free_ns = max(self._free_ns, tick * self._tick_ns) + spent_ns
        acts = max(tick, -((self._given_ns - self._free_ns) // self._tick_ns))
        following = max(tick + 1, self._free_ns // self._tick_ns)
        if self._repeated is not None:
            acts, following = self._repeated.get(tick, (tick, tick + 1))
        if (acts, following) != (tick, tick + 1):
            self.record.append([tick, acts, following])
        return acts, following


class TimedDriver:
    """A driver process whose answers act when its core has computed them, as the car's software.

    Attributes:
        path, reason: see DriverProcess
        problem: why the driver has ended, "" while it drives
    """

    def __init__(self, process: DriverProcess | None, tick_ns: int, late: list | None = None):
        self.path: Path | None = None
        self.reason = self.problem = ""
        self.spent_ms: list[float] = []
        self.lateness = Lateness(tick_ns, late)
        self._process = process
        self._waiting: deque[tuple[int, Command | None]] = deque()
        self._tick = self._following = 0

    def step(self, observation: Observation) -> Command | None:
        """Return the command that acts in this tick."""
        tick, self._tick = self._tick, self._tick + 1
        if self._process and tick == self._following and not self.problem:
            try:
                command = self._process.step(observation)
            except DriverError as error:
                self.problem = str(error)
                return None
            self.path, self.reason = self._process.path, self._process.reason
            acts, self._following = self.lateness.step(tick, self._process.spent_ns)
            self._waiting.append((acts, command))
            self.spent_ms.append(self._process.spent_ns / _NS_PER_MS)
        command = None
        while self._waiting and self._waiting[0][0] <= tick:
            command = self._waiting.popleft()[1]
        return command


class TrueRecorder(DriveRecorder):
    """Evaluates the true motion of a car, until its driver ends; see DriveRecorder."""

    def __init__(self, rules: EvaluationRules, waypoints_m: np.ndarray, world: Simulation):
        super().__init__(rules, waypoints_m, world)
        self._world = world

    def add(self, snapshot: Snapshot, command: Command | None, car: Any) -> bool:
        """Add a tick of the world and the car's answer; return whether the drive is over."""
        true = self._world.vehicle.state
        moment = snapshot._replace(stamp_ns=self._world.stamp_ns, state=true, measured=true)
        if isinstance(command, AckermannTarget):  # of a stack; its steering rate counts, too
            command = replace(self._world.commands.executed)
        if command is not None:
            command.stamp_ns = moment.stamp_ns
        return super().add(moment, command, car) or bool(car.problem)


def drive(
    server: DriverServer, drawn: Draw, late: list | None = None
) -> tuple[dict[str, Any], DriveEvaluation]:
    """Drive, and return the row of the results and the evaluation of the true motion.

    `late` is the record of an earlier drive, which is repeated.
    """
    setup, world, mission = prepared(drawn)
    rules = evaluation_rules(mission.planner, {"map": setup.parameters["map_path"]})
    recorder = TrueRecorder(rules, setup.waypoints_m, world)
    try:
        process = server.start(mission)
    except DriverError as error:
        row = row_of(drawn, recorder, f"it did not start: {error}", [], [], [])
        return row, recorder.evaluator.result()
    car = TimedDriver(process, round(1e9 * world.tick_s), late)
    try:
        loop.drive(world, car, recorder, drawn.longest_s)
    finally:
        refused = process.close()
    row = row_of(drawn, recorder, car.problem, refused, car.lateness.record, car.spent_ms)
    return row, recorder.evaluator.result()


def row_of(
    drawn: Draw,
    recorder: DriveRecorder,
    problem: str,
    refused: list[str],
    late: list,
    spent_ms: list[float],
) -> dict[str, Any]:
    """Return the row of a drive in the results; a driver that has ended has no points."""
    result = recorder.evaluator.result()
    row: dict[str, Any] = {"seed": drawn.seed, "problem": problem, "refused": refused, "late": late}
    row["step_p99_ms"] = float(np.percentile(spent_ms, 99.0)) if spent_ms else 0.0
    names = LEAGUES[drawn.league]["score"]
    if problem or len(result.rows) < 10:
        ended = {"status": "driver ended", "score": 0.0, "trace_sha256": "", "infractions": []}
        return {**row, **ended, "values": {}, "points": dict.fromkeys(names, 0.0)}
    metrics, found = result.metrics, values(result)
    parts = points(drawn.league, found)
    trace = np.ascontiguousarray(result.rows, dtype="<f8").tobytes()
    return {
        **row,
        "status": metrics["status"],
        "score": score(parts, metrics),
        "driving_score": metrics["driving_score"],
        "infractions": [name for name, count in metrics["infractions"].items() if count],
        "values": {name: found[name] for name in names if math.isfinite(found[name])},
        "points": parts,
        "trace_sha256": hashlib.sha256(trace).hexdigest(),
    }


def drive_seed(server: DriverServer, league: str, seed: str, late: list | None = None) -> dict:
    """Drive what a seed draws, and return its row."""
    return drive(server, draw(league, seed), late)[0]
