"""Track traffic lights from picture to picture."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np

from sdc_perception.ground_tracks import GroundTracks, Pose
from sdc_perception.light_detection import LightFinder, LightSettings, SeenLight
from sdc_perception.overlay import draw_lights

# Pictures in a row that must show a new colour until it counts.
_SAME_COLOUR = 2


class TrackedLight(NamedTuple):
    """A traffic light."""

    id: int  # number of the light since the start
    state: int  # RED, YELLOW or GREEN
    x_m: float  # position of the pole in the frame of the odometry [m]
    y_m: float  # the same [m]


class LightTracker:
    """Traffic lights in a sequence of pictures.

    Attributes:
        seen: the lights in the last picture
    """

    def __init__(self, settings: LightSettings, intrinsic: np.ndarray):
        """Prepare the tracker for pictures with the camera matrix `intrinsic` (3, 3) [px]."""
        self.seen: list[SeenLight] = []
        self._finder = LightFinder(settings, intrinsic)
        self._tracks = GroundTracks(settings.tracks)

    def detect(self, image: np.ndarray, pose: Pose, time_s: float) -> list[TrackedLight]:
        """Return the lights in a picture (H, W, 3 or 4) of uint8, BGR first.

        The pose of the car is that in the frame of the odometry.
        """
        self.seen = self._finder.find(image)
        lights = []
        for track in self._tracks.update(self.seen, pose, time_s):
            memory = track.memory
            states = memory.setdefault("states", deque(maxlen=_SAME_COLOUR))
            if track.fresh:
                states.append(track.seen.state)
                if "state" not in memory or states.count(states[-1]) == _SAME_COLOUR:
                    memory["state"] = states[-1]
            x_m, y_m = track.state[:2].tolist()
            lights.append(TrackedLight(track.id, memory["state"], x_m, y_m))
        return lights

    def drawn(self, image: np.ndarray, _pose: Pose, _lights: list[TrackedLight]) -> np.ndarray:
        """Return a BGR picture (H, W, 3) of what was seen in the last picture."""
        return draw_lights(image, self.seen)
