"""Track cars, pedestrians and boxes from picture to picture."""

from __future__ import annotations

import math

import numpy as np

from sdc_common.driving import DetectedObstacle
from sdc_perception.ground_tracks import GroundTrack, GroundTracks, Pose
from sdc_perception.obstacle_detection import BodyFinder, ObstacleSettings, SeenBody
from sdc_perception.overlay import draw_obstacles

# Share of a new measurement of a body's size.
_SIZE_GAIN = 0.2


class ObstacleTracker:
    """Bodies in a sequence of pictures.

    Attributes:
        seen: the bodies in the last picture
    """

    def __init__(self, settings: ObstacleSettings, intrinsic: np.ndarray):
        """Prepare the tracker for pictures with the camera matrix `intrinsic` (3, 3) [px]."""
        self.seen: list[SeenBody] = []
        self._kinds = settings.kinds
        self._finder = BodyFinder(settings, intrinsic)
        self._tracks = {name: GroundTracks(settings.tracks) for name in settings.kinds}

    def detect(self, image: np.ndarray, pose: Pose, time_s: float) -> list[DetectedObstacle]:
        """Return the bodies in a picture (H, W, 3 or 4) of uint8, BGR first.

        One that stands has the line of sight as its heading. The pose of the car is that in the
        frame of the odometry.
        """
        self.seen = self._finder.find(image)
        bodies = []
        for number, (name, tracks) in enumerate(self._tracks.items()):
            seen = [body for body in self.seen if body.kind == name]
            for track in tracks.update(seen, pose, time_s):
                bodies.append(self._body(track, len(self._tracks) * track.id + number, pose))
        return bodies

    def _body(self, track: GroundTrack, number: int, pose: Pose) -> DetectedObstacle:
        seen, memory = track.seen, track.memory
        if track.fresh:
            for name, value in (("depth", seen.depth_m), ("width", seen.width_m)):
                old = memory.get(name, value)
                memory[name] = old + _SIZE_GAIN * (value - old)
        x, y = track.state[:2].tolist()
        sight = math.atan2(y - pose[1], x - pose[0])
        # The track is the middle of the side that faces the car.
        x += 0.5 * memory["depth"] * math.cos(sight)
        y += 0.5 * memory["depth"] * math.sin(sight)
        heading, speed = sight, track.speed_mps
        length, width = memory["depth"], memory["width"]
        if speed > 0.0:
            heading = math.atan2(track.state[3], track.state[2])
            length, width = self._kinds[seen.kind].size_m
        return DetectedObstacle(x, y, heading, length, width, speed, number, seen.kind)

    def drawn(self, image: np.ndarray, _pose: Pose, _bodies: list[DetectedObstacle]) -> np.ndarray:
        """Return a BGR picture (H, W, 3) of what was seen in the last picture."""
        return draw_obstacles(image, self.seen)
