"""Detect the lane in a sequence of pictures."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from sdc_common.validation import is_number
from sdc_package.lane_filter import LaneFilter, LaneFilterThresholds
from sdc_perception.ground_plane import GroundPlane, MountingPose
from sdc_perception.ground_tracks import Pose
from sdc_perception.lane_acquisition import LaneGuess, acquire_lane, marking_points
from sdc_perception.lane_tracker import (
    LEFT,
    RIGHT,
    FoundMarkings,
    LaneSettings,
    LaneTracker,
    TrackedLane,
)
from sdc_perception.marking_search import Box, MarkingSearch, SearchSettings, View
from sdc_perception.obstacle_detection import BodyFinder, ObstacleSettings, covered_boxes
from sdc_perception.overlay import draw_lane

_LONGEST_STEP_M = 5.0
_EARLIER_VIEWS, _VIEWS_APART_M = 2, 0.25
_AROUND_PX, _EVEN = 61, 100.0
_STANDING_PICTURES = 8  # the lane is acquired with up to this many pictures of a car at rest
_STANDING_M = 0.01  # a car at rest moves less than this between two pictures
_DIRECTION_KEYS = {"from_m", "to_m", "keep"}


@dataclass(frozen=True)
class DetectorSettings:
    """Parameters of the lane detector."""

    camera: MountingPose  # pose of the camera
    lane_filter: LaneFilterThresholds  # thresholds of the lane filter
    search: SearchSettings  # what counts as a marking
    lane: LaneSettings  # dimensions of the road and noise
    # Where the road divides: `from_m` and `to_m`, measured from the start of the drive, and `keep`,
    # left or right
    directions: Sequence[Mapping[str, Any]]
    bodies: ObstacleSettings | None  # what can hide the road, None for nothing

    @classmethod
    def read(
        cls, parameter: Callable[[str], Any], bodies: Mapping[str, Any] | None = None
    ) -> DetectorSettings:
        """Return the settings, given a function that returns one of config/lane_detector.yaml.

        `bodies` are the parameters of config/obstacle_detector.yaml.

        Raises:
            TypeError: a name in a section is missing or unknown
            ValueError: a value is out of range
        """
        directions = parameter("directions")
        for direction in directions:
            if not (
                isinstance(direction, dict)
                and set(direction) == _DIRECTION_KEYS
                and is_number(direction["from_m"])
                and is_number(direction["to_m"])
                and direction["keep"] in (LEFT, RIGHT)
            ):
                raise ValueError(
                    f"directions: write {{from_m: 70, to_m: 110, keep: left}}, got {direction}"
                )
        try:
            hiding = ObstacleSettings.read(bodies.__getitem__) if bodies else None
        except (TypeError, ValueError) as error:
            raise ValueError(f"bodies, from config/obstacle_detector.yaml: {error}") from error
        return cls(
            MountingPose(**parameter("camera")),
            LaneFilterThresholds(**parameter("lane_filter")),
            SearchSettings(**parameter("search")),
            LaneSettings(**parameter("lane")),
            directions,
            hiding,
        )


def evened(image: np.ndarray) -> np.ndarray:
    """Return a picture (H, W, 4) whose brightness is even: in a deep shadow, gradients are small.

    Reference: D. J. Jobson, Z. Rahman and G. A. Woodell, Properties and Performance of a
    Center/Surround Retinex, IEEE Transactions on Image Processing 6(3), 1997.
    """
    gray = cv2.cvtColor(image, cv2.COLOR_BGRA2GRAY)
    around = cv2.blur(gray, (_AROUND_PX, _AROUND_PX)).astype(np.float32)
    gain = _EVEN / np.maximum(around, 1.0)
    return np.clip(image * gain[..., None], 0.0, 255.0).astype(np.uint8)


class StandingPictures:
    """The darkest of some pictures from one place: streaks of rain are bright and do not stay.

    Reference: K. Garg and S. K. Nayar, Detection and Removal of Rain from Videos, Conference on
    Computer Vision and Pattern Recognition, 2004: a drop brightens a pixel in one picture only.

    Attributes:
        darkest: picture (H, W, 4)
    """

    def __init__(self, image: np.ndarray, position: tuple[float, float]):
        self.darkest = image.copy()
        self._position = position
        self._number = 1

    def add(self, image: np.ndarray, position: tuple[float, float]) -> bool:
        """Add a picture; return False if it is from another place, or there are enough."""
        away_m = math.dist(position, self._position)
        if away_m > _STANDING_M or self._number >= _STANDING_PICTURES:
            return False
        np.minimum(self.darkest, image, out=self.darkest)
        self._number += 1
        return True


class LaneDetector:
    """A detector that acquires the lane in one picture and tracks it in the next ones.

    Attributes:
        ground: projection of the camera
        tracker: tracker of the lane, None while the lane is not found
        driven_m: distance that the odometry has measured since the start [m]
    """

    def __init__(self, settings: DetectorSettings, intrinsic: np.ndarray):
        """Prepare the detector for pictures with the camera matrix `intrinsic` (3, 3) [px]."""
        self.ground = GroundPlane(intrinsic, settings.camera)
        self.tracker: LaneTracker | None = None
        self._settings = settings
        self._filter = LaneFilter(settings.lane_filter)
        self._search = MarkingSearch(self.ground, settings.search)
        self._bodies = BodyFinder(settings.bodies, intrinsic) if settings.bodies else None
        self._position: tuple[float, float] | None = None
        self._earlier: list[View] = []
        self._standing: StandingPictures | None = None
        self.driven_m = 0.0

    def detect(self, image: np.ndarray, pose: Pose, _time_s: float = 0.0) -> TrackedLane | None:
        """Return the lane, or None if there is none in the picture (H, W, 4) of BGRA uint8.

        The pose of the car is that in the frame of the odometry.
        """
        # There are no markings on a body.
        covered = covered_boxes(self._bodies.find(image)) if self._bodies else ()
        position = (pose[0], pose[1])
        step_m = math.dist(position, self._position or position)
        self._position = position
        if step_m > _LONGEST_STEP_M:  # the odometry has started again
            self.tracker = None
            self._earlier = []
        else:
            self.driven_m += step_m
        if self._standing is not None and not self._standing.add(image, position):
            self._standing = None
        if self.tracker is None and self._standing is None:
            self._standing = StandingPictures(image, position)
        if self._standing is not None:
            image = self._standing.darkest
            self._acquire(image, pose)
        if self.tracker is None:
            return None
        lane = self.tracker.update(self._views(image, pose, covered), self._keep())
        if lane.confidence <= 0.0:
            self.tracker = None
        return lane

    def _views(self, image: np.ndarray, pose: Pose, covered: Sequence[Box]) -> list[View]:
        """Return the picture, and before it those from some places behind it."""
        newest = View.of(image, pose, covered)
        views = [newest, *self._earlier]
        if not self._earlier or math.dist(pose[:2], self._earlier[0].pose[:2]) > _VIEWS_APART_M:
            self._earlier = [newest.as_earlier(), *self._earlier][:_EARLIER_VIEWS]
        return views

    def drawn(self, image: np.ndarray, pose: Pose, lane: TrackedLane | None) -> np.ndarray:
        """Return a BGR picture (H, W, 3) of a lane and the markings of the last picture."""
        return draw_lane(image, self.ground, pose, lane, self.found)

    @property
    def found(self) -> FoundMarkings | None:
        """Return the markings in the last picture, None while the lane is not found."""
        return self.tracker.found if self.tracker else None

    @property
    def lines_m(self) -> np.ndarray:
        """Return the offsets (3,) of right edge, dashes and left edge from the centre [m]."""
        return self._settings.lane.lines_m

    def marking_points(self, image: np.ndarray, **search: int) -> np.ndarray:
        """Return the ground points (N, 2) [m] on markings in a picture (H, W, 4) BGRA."""
        gray = cv2.cvtColor(image, cv2.COLOR_BGRA2GRAY)
        return marking_points(self._filter.mask(image), gray, self.ground, **search)

    def guess(self, image: np.ndarray) -> LaneGuess | None:
        """Return the lane in a picture (H, W, 4) BGRA without knowledge from pictures before."""
        guess = acquire_lane(self.marking_points(image), self.lines_m)
        if guess is None:
            even = evened(image)
            guess = acquire_lane(self.marking_points(even), self.lines_m)
        if guess is None:  # worn lines: what is left of them is in few rows
            guess = acquire_lane(self.marking_points(even, row_step=1), self.lines_m)
        return guess

    def _acquire(self, image: np.ndarray, pose: Pose) -> None:
        guess = self.guess(image)
        if guess is not None:
            self.tracker = LaneTracker(self._search, self._settings.lane, pose, guess)

    def _keep(self) -> str | None:
        for direction in self._settings.directions:
            if direction["from_m"] <= self.driven_m < direction["to_m"]:
                return direction["keep"]
        return None
