"""Track cars, pedestrians and boxes from picture to picture."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from sdc_common.validation import check_finite
from sdc_perception.ground_plane import MountingPose
from sdc_perception.ground_tracks import GroundTrack, GroundTracks, Pose, Sighting, TrackSettings
from sdc_perception.obstacle_detection import BodyFinder, BodySettings, SeenBody

# Share of a new measurement of a body's size.
_SIZE_GAIN = 0.2


@dataclass(frozen=True)
class ObstacleSettings:
    """Parameters of the obstacle detector."""

    camera: MountingPose  # pose of the camera
    kinds: dict[str, BodySettings]  # what the kinds of bodies look like
    farthest_m: float  # greatest distance at which a body counts [m]
    tracks: TrackSettings  # how tracks begin, move and end

    @classmethod
    def read(cls, parameter: Callable[[str], Any]) -> ObstacleSettings:
        """Return the settings.

        Args:
            parameter: returns the parameter of config/obstacle_detector.yaml with a given name

        Raises:
            TypeError: a name in a section is missing or unknown
            ValueError: a value is out of range
        """
        camera = MountingPose(**parameter("camera"))
        check_finite(**vars(camera))
        kinds = {}
        for name, values in parameter("kinds").items():
            try:
                kinds[name] = BodySettings(**values)
            except (TypeError, ValueError) as error:
                raise ValueError(f"kinds/{name}: {error}") from error
        return cls(camera, kinds, parameter("farthest_m"), TrackSettings(**parameter("tracks")))


def body_finder(settings: ObstacleSettings, intrinsic: np.ndarray) -> BodyFinder:
    """Return the finder for pictures with the camera matrix `intrinsic` (3, 3) [px]."""
    return BodyFinder(intrinsic, settings.camera, settings.kinds, settings.farthest_m)


class TrackedBody(NamedTuple):
    """A body on the ground, in the frame of the odometry."""

    id: int  # number of the body since the start
    kind: str  # name of the kind
    x_m: float  # centre [m]
    y_m: float  # centre [m]
    yaw_rad: float  # heading if it moves, else the line of sight [rad]
    length_m: float  # size along the heading [m]
    width_m: float  # size across the heading [m]
    speed_mps: float  # speed along the heading [m/s]


class ObstacleTracker:
    """Bodies in a sequence of pictures.

    Attributes:
        seen: the bodies in the last picture
    """

    def __init__(self, settings: ObstacleSettings, intrinsic: np.ndarray):
        """Prepare the tracker for pictures with the camera matrix `intrinsic` (3, 3) [px]."""
        self.seen: list[SeenBody] = []
        self._kinds = settings.kinds
        self._finder = body_finder(settings, intrinsic)
        self._tracks: dict[str, GroundTracks[SeenBody]] = {
            name: GroundTracks(settings.tracks) for name in settings.kinds
        }

    def detect(self, image: np.ndarray, pose: Pose, time_s: float) -> list[TrackedBody]:
        """Return the bodies.

        Args:
            image: (H, W, 3 or 4) BGR first, uint8
            pose: x [m], y [m] and yaw [rad] of the car in the frame of the odometry
            time_s: time of the picture [s]
        """
        self.seen = self._finder.find(image)
        bodies = []
        for number, (name, tracks) in enumerate(self._tracks.items()):
            sightings = [
                Sighting(body.x_m, body.y_m, body.distance_deviation_m, body)
                for body in self.seen
                if body.kind == name
            ]
            for track in tracks.update(sightings, pose, time_s):
                bodies.append(self._body(track, len(self._tracks) * track.id + number, pose))
        return bodies

    def _body(self, track: GroundTrack[SeenBody], number: int, pose: Pose) -> TrackedBody:
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
        speed = track.speed_mps
        if speed == 0.0:
            size = memory["depth"], memory["width"]
            return TrackedBody(number, seen.kind, x, y, sight, *size, 0.0)
        heading = math.atan2(track.state[3], track.state[2])
        size = self._kinds[seen.kind].size_m
        return TrackedBody(number, seen.kind, x, y, heading, *size, speed)
