"""Lets a stack drive, by all.launch as a person would start it, and holds its report against limits."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

from sdc_sim.scenario.acceptance_limits import AcceptanceLimits, read_report, violations
from sdc_sim.scenario.reader import load_scenario
from sdc_sim.scenario.runner import Packaged, find_scenario, prepare

_ENDS_WITHIN_S = 30.0
_SHOWN_LINES = 25


class CheckedDrive:
    """One drive of a scenario (a name or a path; none: the route alone) with the given arguments of all.launch over it.

    Raises ScenarioError, WaypointError and OSError for what cannot be driven at all.
    """

    def __init__(self, scenario: str, report_path: str, given: dict):
        self.report_path = report_path
        self.log_path = os.path.splitext(report_path)[0] + ".log"
        os.makedirs(os.path.dirname(report_path), exist_ok=True)
        self.limits, camera = AcceptanceLimits(), True
        if scenario:
            packaged = Packaged.found()
            loaded = load_scenario(find_scenario(scenario, packaged))
            self.limits, camera = loaded.limits, loaded.camera
            given = prepare(scenario, report_path, given, packaged)
        self.arguments = {
            "sync": "true",
            "camera": str(camera).lower(),
            **given,
            "headless": "true",
            "report": report_path,
        }

    def run(self, wall_limit_s: float, stopped=lambda: False, environment=None) -> list:
        """Drive to the end, until `stopped`, or for as long as wall_limit_s; returns what fell short, one line each, and, where
        anything did, the last lines that the launch said. The launch and all its nodes have ended then."""
        if os.path.exists(self.report_path):
            os.remove(self.report_path)
        status = self._launch(wall_limit_s, stopped, environment)
        try:
            lines = violations(self.limits, *read_report(self.report_path))
        except (OSError, ValueError) as error:
            lines = [f"roslaunch ended with {status} and left no report ({error})"]
        return [*lines, self._last_words()] if lines else []

    def _launch(self, wall_limit_s, stopped, environment):
        command = [
            sys.executable,
            "-m",
            "sdc_common.ros.safe_launch",
            "sdc_package",
            "all.launch",
            *(f"{key}:={value}" for key, value in self.arguments.items()),
        ]
        with open(self.log_path, "wb") as log:
            launch = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=environment,
                start_new_session=True,
            )
        limit = time.monotonic() + wall_limit_s
        try:
            while launch.poll() is None and time.monotonic() < limit and not stopped():
                time.sleep(0.05)
        finally:
            _end(launch)
        return launch.returncode

    def _last_words(self) -> str:
        with open(self.log_path, encoding="utf-8", errors="replace") as file:
            lines = file.read().splitlines()[-_SHOWN_LINES:]
        return "\n".join([f"the last lines of {self.log_path}:", *lines])


def _end(launch) -> None:
    """An interrupt, as from a keyboard, lets roslaunch end its nodes."""
    for sent in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        if launch.poll() is not None:
            return
        os.killpg(launch.pid, sent)
        try:
            launch.wait(_ENDS_WITHIN_S)
        except subprocess.TimeoutExpired:
            continue
