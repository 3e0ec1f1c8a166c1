"""The state of the sim node that survives a kill."""

from __future__ import annotations

from typing import Any

import rospy

from sdc_common.ros.checkpoint import Checkpoint
from sdc_common.ros.node import refuse
from sdc_sim.ros.command_input import CommandInput
from sdc_sim.simulation.pause import PauseControl
from sdc_sim.simulation.simulation import Simulation


class SavedDrive:
    """Saves the drive in each tick and restores it after a kill.

    Attributes:
        restored: whether the drive continues one in which this node was killed
    """

    def __init__(self, simulation: Simulation, pause: PauseControl, commands: CommandInput):
        self._simulation = simulation
        self._pause = pause
        self._commands = commands
        self._checkpoint = Checkpoint()
        self.restored = self._restore()

    def save(self) -> None:
        """Save the drive as it is now."""
        saved = self._checkpoint.save(
            {
                "simulation": self._simulation.checkpoint(),
                "pause": self._pause.checkpoint(),
                "commands": self._commands.checkpoint(),
            }
        )
        if not saved and self._checkpoint.failure:
            rospy.logwarn_once(
                f"sim: cannot save its state ({self._checkpoint.failure}); if this node is killed, "
                "the drive starts again"
            )

    def _restore(self) -> bool:
        state: Any = self._checkpoint.load()
        if state is None:
            return False
        try:
            self._simulation.restore(state["simulation"])
            self._pause.restore(*state["pause"])
            self._commands.restore(state["commands"])
        except (KeyError, TypeError, ValueError) as error:
            refuse(f"the saved state belongs to another drive ({error}); start the drive again")
        rospy.logwarn("sim: restarted; the simulation resumes at tick %d", self._simulation.tick)
        return True
