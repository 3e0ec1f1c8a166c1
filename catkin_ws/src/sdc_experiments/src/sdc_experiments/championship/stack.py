"""Drives of ROS nodes with the draws of the championship, without sandbox and limit of time."""

from __future__ import annotations

import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from sdc_common.configuration import package_folder
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


def drive_script() -> str:
    """Return the path of ./drive.

    Raises:
        ValueError: only the wheel is installed
    """
    path = Path(package_folder("sdc_experiments")).parents[2] / "drive"
    if not path.exists():
        raise ValueError("stack: drives through ROS, which needs the project's source tree")
    return str(path)


def drive_stack(stack: str, workspace: str, league: str, seed: str) -> LoggedDriver:
    """Drive what a seed draws through ROS, and return a driver that repeats the commands.

    With them the world repeats the drive in this process, which gives the true motion.

    Raises:
        ValueError: the drive has no log; the message names its output
    """
    one = draw(league, seed)
    with tempfile.TemporaryDirectory(prefix="championship_") as name:
        folder = Path(name)
        options = {**one.sim, "drive_log": str(folder / "log")}
        command = [drive_script(), f"stack:={stack}", f"workspace:={workspace}"]
        command.append(f"report:={folder / 'report.json'}")
        command += [f"sim_options:={options_text(options)}", f"map:={one.map}", "sync:=true"]
        command += [f"planner_options:={options_text(one.planner)}", "headless:=true"]
        command += ["camera:=false", "referee_options:={pictures: false}"]
        if one.route_m is not None:
            # The y axis of a waypoint file points to the right.
            np.savetxt(folder / "route.csv", one.route_m * (1.0, -1.0), "%.9f", ",")
            command.append(f"waypoints_path:={folder / 'route.csv'}")
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if not (folder / "log").exists():
            raise ValueError(f"seed {seed}: the drive has no log: {done.stderr.strip()[-300:]}")
        return LoggedDriver((folder / "log").read_text(encoding="ascii"))
