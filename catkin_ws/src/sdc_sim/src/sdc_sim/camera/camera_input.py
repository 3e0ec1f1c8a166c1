"""What the process of the cameras receives for each picture."""

from __future__ import annotations

from typing import NamedTuple

from sdc_sim.simulation.observation import Observation


class CameraInput(NamedTuple):
    """What a picture depends on.

    Attributes:
        observation: the observation
        daylight: brightness, 0..1
        spectator: x, y, z [m], yaw and pitch [rad] of the spectator's camera on the vehicle; None
            until it has been placed
    """

    observation: Observation
    daylight: float
    spectator: tuple[float, float, float, float, float] | None
