"""Drives of ROS nodes with the draws of the championship, without sandbox and limit of time."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any, Mapping

from sdc_common.driving import Command, Observation
from sdc_experiments.championship.league import draw
from sdc_experiments.championship.mission import DriverMission
from sdc_sim.physics.ackermann import AckermannTarget
from sdc_sim.scenario.packaged import options_text
from sdc_sim.simulation.command_mux import AnyCommand


class LoggedDriver:
    """Repeats the commands of the log of a drive; see sdc_sim.ros.drive_log."""

    spent_ns, path, reason = 0, None, ""

    def __init__(self, log: str):
        self._commands: list[AnyCommand | None] = []
        for name, _, *values in map(json.loads, log.splitlines()):
            if name == "odometry":
                self._commands.append(None)
            elif name == "command" and self._commands:
                throttle, brake, steer = values
                self._commands[-1] = Command(throttle, steer, brake)
            elif name == "target" and self._commands:
                self._commands[-1] = AckermannTarget(*values)

    def start(self, _mission: DriverMission) -> LoggedDriver:
        """Return the driver."""
        self._left = iter(self._commands)
        return self

    def step(self, _observation: Observation) -> AnyCommand | None:
        """Return the command of the next tick, None after the last one."""
        return next(self._left, None)

    def close(self) -> list[str]:
        """Return what it was refused."""
        return []


def nodes_drive(arguments: Mapping[str, str], **options: Any) -> Any:
    """Return the drive of a stack, see sdc_sim.runner.isolated_drive.

    Raises:
        ValueError: only the wheel is installed
    """
    try:
        from sdc_sim.runner import isolated_drive
    except ImportError as error:
        raise ValueError(
            f"stack: drives through ROS, which needs the workspace ({error})"
        ) from None
    return isolated_drive("", arguments, **options)


def drive_stack(stack: str, workspace: str, league: str, seed: str) -> LoggedDriver:
    """Drive what a seed draws through ROS, and return a driver that repeats the commands.

    With them the world repeats the drive in this process, which gives the true motion.

    Raises:
        ValueError: the drive has no log; the message has the end of its output
    """
    drawn = draw(league, seed)
    with tempfile.TemporaryDirectory(prefix="championship_") as folder:
        log = Path(folder, "log")
        arguments = {"stack": stack, "workspace": workspace, "map": drawn.map, "camera": "false"}
        arguments["sim_options"] = options_text({**drawn.sim, "drive_log": str(log)})
        arguments["planner_options"] = options_text(drawn.planner)
        with nodes_drive(arguments, route_m=drawn.route_m) as (_, lines):
            if not log.exists():
                raise ValueError(f"seed {seed}: the drive has no log: {' '.join(lines)[-300:]}")
            return LoggedDriver(log.read_text(encoding="ascii"))
