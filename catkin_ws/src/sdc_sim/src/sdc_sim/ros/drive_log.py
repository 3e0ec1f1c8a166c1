"""A record of a drive by the simulator itself, from which the drive can be evaluated.

Every node can publish on every topic; only the simulator writes this file. Each line is an event
of DriveEvaluation as JSON: ["odometry", stamp, x, y, yaw, speed], ["command", stamp, throttle,
brake, steer], ["collision", stamp, obstacle]; or ["target", stamp, fields of AckermannTarget].
"""

from __future__ import annotations

import json
from dataclasses import astuple
from typing import Any

from nav_msgs.msg import Odometry

from sdc_common.ros.odometry import pose_and_speed
from sdc_sim.physics.ackermann import AckermannTarget
from sdc_sim.simulation.snapshot import Snapshot


class DriveLog:
    """Appends events to a file."""

    def __init__(self, path: str):
        """Open the file.

        Raises:
            OSError: the file cannot be written
        """
        # Each line is written at once. The file is open until the end.
        self._file = open(path, "a", buffering=1, encoding="ascii")  # noqa: SIM115

    def add_observation(self, observation: Snapshot, odometry: Odometry) -> None:
        """Add the pose and speed that the odometry holds, and the collisions of this tick."""
        for event in observation.collisions:
            self._write(["collision", observation.stamp_ns, event.id])
        self._write(["odometry", observation.stamp_ns, *map(float, pose_and_speed(odometry))])

    def add_command(self, message: Any) -> None:
        """Add a command that the simulator received."""
        stamp_ns = message.header.stamp.to_nsec()
        self._write(["command", stamp_ns, message.throttle, message.brake, message.steer])

    def add_target(self, stamp_ns: int, target: AckermannTarget) -> None:
        """Add a target that the simulator received in a tick."""
        self._write(["target", stamp_ns, *astuple(target)])

    def _write(self, event: list) -> None:
        self._file.write(json.dumps(event) + "\n")
