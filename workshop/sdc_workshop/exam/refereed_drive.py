"""The drive of a strange car: no file and no message of its programs decides about its result.

The simulator runs outside of the student's sandbox, with parameters that it has read before the
first of the student's programs starts, and without the services that pause it or place the car. It
writes each true pose and each command to a file. The referee here reads that file. It evaluates the
drive along the route of the packaged waypoint file, with the packaged configuration. The student's
all.launch starts the student's nodes; the world's launch files that it includes are empty there.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import secrets
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import IO, Sequence

import numpy as np
import psutil
import yaml

from sdc_common.driving import points_as_sent
from sdc_common.ros.odometry import GROUND_TRUTH
from sdc_common.routes.waypoint_file import load_waypoints
from sdc_sim.evaluation.evaluator import Evaluator
from sdc_sim.evaluation.rules import EvaluationRules
from sdc_sim.report.console_progress import closing_line
from sdc_sim.report.writer import write_pages, write_report
from sdc_sim.ros.picture_feed import KEY_VARIABLE
from sdc_workshop.exam.process import NotJudged, Program
from sdc_workshop.exam.stage import Stage
from sdc_workshop.workspace import PACKAGE, SOLUTION

START_TIMEOUT_S = 60.0
# The drive ends after this wall-clock time without a command, and so much processor time [s]; but
# only the former counts when no program has computed for so many looks.
STALL_S = 30.0
_IDLE_LOOKS = 20
_POLL_S = 0.05
# The last command may arrive after the end of the drive.
_LATE_S = 0.2
ROUTE = SOLUTION / "sdc_common" / "data" / "waypoints.csv"
_WORLD_LAUNCH = SOLUTION / "sdc_sim" / "launch"
# The simulator's two processes; the second one runs where there is a camera.
_SIMULATOR = "/sim"
_CAMERA = "/front_camera"
_MISSION = "/planner/mission_waypoints"


def refereed_drive(
    stage: Stage,
    arguments: list,
    report: Path,
    world: Sequence[str] = (),
    route: Path = ROUTE,
    is_unseen: bool = False,
) -> str:
    """Drive, and write the report.

    The drive ends by the rules, whose time is simulated, or when no command comes. A busy machine
    makes it longer: the only limit of its wall time is that of the whole check, which judges no
    step that it ends.

    Args:
        stage: with a sandbox
        arguments: package and launch file of the student, and arguments
        report: file of the report; without a command to the car it is not written
        world: further launch arguments of the world
        route: waypoint file of the road, which the car finds in the place of the packaged one
        is_unseen: whether the car does not know the road; it arrives when it passes the end

    Returns:
        the output with a line of the result
    """
    assert stage.sandbox is not None
    folder = stage.folder / f"drive_{report.parent.name}"
    folder.mkdir(exist_ok=True)  # the second attempt of a drive that was not judged
    log = stage.hidden / f"events_{report.parent.name}"
    log.write_text("", encoding="ascii")
    world = [*world, f"waypoints_path:={route}"]
    with _world(stage, log, world) as simulator, log.open(encoding="ascii") as events:
        own_report = stage.folder / "tmp" / "report.json"
        replaced = {
            _WORLD_LAUNCH / name: _without_nodes(folder, name)
            for name in ("sim.launch", "referee.launch")
        }
        if route != ROUTE and not is_unseen:
            replaced[ROUTE] = route
        command = ["roslaunch", "--skip-log-check", *arguments, f"report:={own_report}"]
        with stage.start(command, stage.environment(), replaced=replaced) as stack:
            referee = _Referee(stage, events, route, is_unseen)
            referee.watch(simulator, stack)
            with contextlib.suppress(psutil.Error):
                if os.path.lexists(f"/proc/{stack.main.pid}/root{own_report}"):
                    stage.report("a report.json was written; it does not count")
        time.sleep(_LATE_S)
        referee.read()
    line = referee.write(report)
    return f"{line}\n{stack.output}"


def _world(stage: Stage, log: Path, more: Sequence[str]) -> Program:
    """Return the simulator, which has read its parameters."""
    options = json.dumps({"drive_log": str(log), "services": False, "ground_truth": False})
    arguments = ("sync:=true", f"sim_options:={options}", *more)
    stage.master  # noqa: B018  roslaunch uses a master that already runs
    command = ["roslaunch", "--skip-log-check", "sdc_sim", "sim.launch", *arguments]
    environment = {**stage.world_environment, KEY_VARIABLE: secrets.token_hex()}
    world = Program(command, environment, stage.folder)
    limit = time.monotonic() + START_TIMEOUT_S
    needed = {_SIMULATOR, _CAMERA} if "camera:=true" in more else {_SIMULATOR}
    while True:
        published = stage.state()[0]
        if "/clock" in published and needed <= {*itertools.chain(*published.values())}:
            return world
        if world.status is not None or time.monotonic() > limit:
            world.end()
            raise NotJudged(f"the simulator does not start: {world.output[-500:]}")
        time.sleep(_POLL_S)


def _without_nodes(folder: Path, name: str) -> Path:
    """Write a launch file of the world that takes the same arguments and starts nothing."""
    root = ElementTree.parse(_WORLD_LAUNCH / name).getroot()
    for child in list(root):
        if child.tag != "arg":
            root.remove(child)
    path = folder / name
    path.write_text(ElementTree.tostring(root, encoding="unicode"), encoding="utf-8")
    return path


def packaged_rules(finish_at_rest: bool) -> EvaluationRules:
    """Return the rules of the packaged configuration, whatever the student's planner has."""

    def settings(package: str, name: str) -> dict:
        path = SOLUTION / package / "config" / name
        return yaml.safe_load(path.read_text(encoding="utf-8"))

    planner = settings(PACKAGE, "local_planner.yaml")
    rules = EvaluationRules.read(settings("sdc_sim", "referee.yaml").__getitem__)
    limits = {name: planner[name] for name in rules.planner}
    return rules._replace(planner=limits, assumed=[], finish_at_rest=finish_at_rest)


class _Referee:
    """Evaluates a drive from the file that the simulator writes."""

    def __init__(self, stage: Stage, events: IO, route: Path, is_unseen: bool):
        from sdc_package.msg import Path as Mission

        from sdc_workshop.exam.node import Received

        self._stage = stage
        self._events = events
        self._part = ""
        self._commands = 0
        # As in the messages, whose numbers have 32 bits.
        self._route = points_as_sent(load_waypoints(str(route)))
        self._evaluator = Evaluator(packaged_rules(finish_at_rest=not is_unseen))
        self._is_unseen = is_unseen
        self._evaluator.set_route(self._route)
        self._missions = Received(_MISSION, Mission)
        self._world_topics = {
            topic for topic, nodes in stage.state()[0].items() if {_SIMULATOR, _CAMERA} & {*nodes}
        } - {"/rosout", "/tf"}

    def watch(self, world: Program, stack: Program) -> None:
        """Follow the drive to its end."""
        stall_s, count, idle, start_s = time.monotonic() + STALL_S, 0, 0, 0.0
        try:
            while True:
                self.read()
                self._look_for_forgery()
                if self._commands > count:
                    count, stall_s = self._commands, time.monotonic() + STALL_S
                    idle, start_s = 0, 0.0
                if world.status is not None:
                    self._stage.report("the simulator was ended by another program")
                    return
                if self._evaluator.over or stack.status is not None:
                    return
                if time.monotonic() > stall_s:
                    cpu_s, runs = stack.activity(of_all=True)
                    start_s = start_s or cpu_s
                    idle = 0 if runs or world.activity(of_all=True)[1] else idle + 1
                    if idle > _IDLE_LOOKS or cpu_s - start_s > STALL_S:
                        return
                time.sleep(_POLL_S)
        finally:
            self._missions.subscriber.unregister()

    def read(self) -> None:
        """Evaluate what the simulator has written since the last call."""
        lines = (self._part + self._events.read()).split("\n")
        self._part = lines.pop()
        for line in lines:
            event = json.loads(line)
            if event[0] == "odometry":
                event.append(time.monotonic())
            self._commands += event[0] == "command"
            self._evaluator.add(*event)

    def write(self, report: Path) -> str:
        """Write the report; return a line that sums it up."""
        if not self._commands or not self._evaluator.started:
            return "referee: the drive did not start: no command to the car"
        result = self._evaluator.result()
        write_report(str(report), result)
        write_pages(str(report), result)
        return closing_line(result.metrics)

    def _look_for_forgery(self) -> None:
        """Report nodes that use the truth or publish as the simulator, and another mission."""
        published, subscribed, _ = self._stage.state()
        for node in subscribed.get(GROUND_TRUTH, ()):
            text = f"{node} subscribes to {GROUND_TRUTH}, which is for the referee alone"
            self._stage.report(text)
        for topic in sorted(self._world_topics):
            others = set(published.get(topic, ())) - {_SIMULATOR, _CAMERA}
            for node in sorted(others):
                self._stage.report(f"{node} publishes {topic} in the place of the simulator")
        for mission in self._missions.messages[:1]:
            points = [(point.x, point.y) for point in mission.waypoints]
            known = np.array_equal(np.reshape(points, (-1, 2)), self._route)
            if not known and not self._is_unseen:
                text = "another mission is published; the drive is measured on the route"
                self._stage.report(text)
