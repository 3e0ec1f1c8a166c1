"""Track what is seen on the ground, in the frame of the odometry."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Tuple

import numpy as np

from sdc_common.validation import check_non_negative, check_positive

Pose = Tuple[float, float, float]  # x [m], y [m], yaw [rad]

# Greatest distance between a sighting and its track, in standard deviations.
_GATE = 4.0
# Systematic errors, which more pictures do not reduce.
_DISTANCE_SHARE = 0.03  # of a distance, as a share of it
_SIDE_M = 0.1
_AHEAD_M = 0.1
_BEARING_RAD = 0.003


@dataclass(frozen=True)
class TrackSettings:
    """How tracks begin, move and end."""

    confirm: int  # sightings until a track counts
    lost_s: float  # time without a sighting after which a track ends [s]
    drift_m: float  # uncertainty of a position that is added in each picture [m]
    # Standard deviation of the acceleration; 0 for things that do not move [m/s^2]
    acceleration_mps2: float
    start_mps: float  # standard deviation of the speed of a new track [m/s]

    def __post_init__(self):
        check_positive(confirm=self.confirm, lost_s=self.lost_s)
        check_non_negative(
            drift_m=self.drift_m,
            acceleration_mps2=self.acceleration_mps2,
            start_mps=self.start_mps,
        )


@dataclass
class GroundTrack:
    """Something on the ground."""

    id: int  # number of the track
    state: np.ndarray  # x [m], y [m], and their rates [m/s]
    covariance: np.ndarray  # covariance of the state (4, 4)
    seen: Any  # the last sighting
    last_s: float  # time of the last sighting [s]
    sightings: int = 1  # number of sightings
    fresh: bool = True  # whether the last picture shows it
    # What the owner of the tracks remembers of it
    memory: dict[str, Any] = field(default_factory=dict)

    @property
    def speed_mps(self) -> float:
        """Return the speed, 0 unless it differs from 0 by two standard deviations [m/s]."""
        speed = float(math.hypot(self.state[2], self.state[3]))
        if speed == 0.0:
            return 0.0
        along = self.state[2:] / speed
        deviation = math.sqrt(float(along @ self.covariance[2:, 2:] @ along))
        return speed if speed > max(0.3, 2.0 * deviation) else 0.0


class GroundTracks:
    """Kalman filters with constant velocity, one for each track.

    Reference: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and
    Navigation, 2001, section 6.2 (white noise acceleration).
    """

    def __init__(self, settings: TrackSettings):
        self._settings = settings
        self._tracks: list[GroundTrack] = []
        self._next_id = 1
        self._time_s: float | None = None

    def update(self, sightings: Sequence[Any], pose: Pose, time_s: float) -> list[GroundTrack]:
        """Return the confirmed tracks after a picture.

        Args:
            sightings: what the picture shows, with `x_m` ahead of the car's centre and `y_m` to the
                left [m], and `distance_deviation_m`, the deviation along the line of sight [m]
            pose: x [m], y [m] and yaw [rad] of the car in the frame of the odometry
            time_s: time of the picture [s]
        """
        step_s = 0.0 if self._time_s is None else time_s - self._time_s
        if step_s < 0.0:  # the clock has started again
            self._tracks, step_s = [], 0.0
        self._time_s = time_s
        for track in self._tracks:
            self._predict(track, step_s)
        measured = [_in_frame(sighting, pose) for sighting in sightings]
        free = self._match(measured, sightings, time_s)
        for number in free:
            self._begin(measured[number], sightings[number], time_s)
        lost_s = self._settings.lost_s
        self._tracks = [
            track
            for track in self._tracks
            if track.fresh or (track.sightings > 1 and time_s - track.last_s <= lost_s)
        ]
        return [track for track in self._tracks if track.sightings >= self._settings.confirm]

    def _predict(self, track: GroundTrack, step_s: float) -> None:
        settings, track.fresh = self._settings, False
        move = np.eye(4)
        move[0, 2] = move[1, 3] = step_s
        half = np.array(
            [[0.5 * step_s**2, 0.0], [0.0, 0.5 * step_s**2], [step_s, 0.0], [0, step_s]]
        )
        track.state = move @ track.state
        track.covariance = move @ track.covariance @ move.T + settings.acceleration_mps2**2 * (
            half @ half.T
        )
        track.covariance[[0, 1], [0, 1]] += settings.drift_m**2

    def _match(
        self,
        measured: list[tuple[np.ndarray, np.ndarray]],
        sightings: Sequence[Any],
        time_s: float,
    ) -> list[int]:
        """Update each track with the sighting next to it; return the sightings that remain."""
        pairs = []
        for number, (point, noise) in enumerate(measured):
            for track in self._tracks:
                error = point - track.state[:2]
                spread = track.covariance[:2, :2] + noise
                distance = float(error @ np.linalg.solve(spread, error))
                if distance < _GATE**2:
                    pairs.append((distance, number, track))
        free, taken = set(range(len(measured))), set()
        for _, number, track in sorted(pairs, key=lambda pair: pair[:2]):
            if number in free and track.id not in taken:
                free.discard(number)
                taken.add(track.id)
                _correct(track, *measured[number])
                track.seen, track.last_s, track.fresh = sightings[number], time_s, True
                track.sightings += 1
        return sorted(free)

    def _begin(self, measured: tuple[np.ndarray, np.ndarray], seen: Any, time_s: float) -> None:
        point, noise = measured
        covariance = np.zeros((4, 4))
        covariance[:2, :2] = noise
        covariance[2:, 2:] = np.eye(2) * self._settings.start_mps**2
        state = np.array([point[0], point[1], 0.0, 0.0])
        self._tracks.append(GroundTrack(self._next_id, state, covariance, seen, time_s))
        self._next_id += 1


def _in_frame(sighting: Any, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
    """Return position (2,) and covariance (2, 2) of a sighting in the frame of the odometry."""
    x, y, yaw = pose
    c, s = math.cos(yaw), math.sin(yaw)
    point = np.array(
        [x + c * sighting.x_m - s * sighting.y_m, y + s * sighting.x_m + c * sighting.y_m]
    )
    distance = math.hypot(sighting.x_m, sighting.y_m)
    bearing = yaw + math.atan2(sighting.y_m, sighting.x_m)
    sight = np.array([math.cos(bearing), math.sin(bearing)])
    across = np.array([-sight[1], sight[0]])
    along_m = math.hypot(sighting.distance_deviation_m, _AHEAD_M, _DISTANCE_SHARE * distance)
    side_m = math.hypot(_SIDE_M, _BEARING_RAD * distance)
    return point, along_m**2 * np.outer(sight, sight) + side_m**2 * np.outer(across, across)


def _correct(track: GroundTrack, point: np.ndarray, noise: np.ndarray) -> None:
    spread = track.covariance[:2, :2] + noise
    gain = track.covariance[:, :2] @ np.linalg.inv(spread)
    track.state = track.state + gain @ (point - track.state[:2])
    rest = np.eye(4)
    rest[:, :2] -= gain
    # Joseph's form stays symmetric.
    track.covariance = rest @ track.covariance @ rest.T + gain @ noise @ gain.T
