"""Find cars, pedestrians and boxes in a picture, and where they are on the ground."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import cv2
import numpy as np

from sdc_common.validation import check_between, check_positive
from sdc_perception.ground_plane import GroundPlane, MountingPose
from sdc_perception.ground_tracks import TrackSettings
from sdc_perception.light_detection import check_pairs, colour_mask

# Smooth edges make a body larger in the picture by so much at each edge [px].
_WIDER_PX = 0.7
_EDGE_PX = 0.5
_LEAST_PIXELS = 12
# Where the lower edge steps by more than this share of its distance from the horizon, a body that
# is nearer hides the other one in part.
_STEP = 0.12
# Half the width of a wheel by the height of the camera above the lower edge of a car.
_WHEEL = 0.36
# Least width of a body next to a nearer one, as a share of the width of its kind.
_ARM = 0.4
# Limits for two parts of one body.
_POLE_M = 1.0  # greatest gap
_SAME_DISTANCE = 1.12  # greatest ratio of the distances
_LONGEST = 1.1  # greatest width of both as a share of the diagonal of the body
# Wheels and shadow, which a body covers beyond its coloured part.
_COVERED_ASIDE = 0.08  # share of its width
_COVERED_BELOW = 0.35  # share of its height


@dataclass(frozen=True)
class BodySettings:
    """What a kind of body looks like."""

    hue: tuple[int, int]  # hues, from and to, 0..180; the range may pass 180
    saturation: int  # least saturation, 0..255
    bottom_m: float  # height of the lower edge of what has this colour [m]
    top_m: float  # height of its upper edge [m]
    width_m: tuple[float, float]  # width, across the line of sight, from and to [m]
    # Length and width of the body; it shows its length if it looks wider than its width [m]
    size_m: tuple[float, float]

    def __post_init__(self):
        check_between(0, 255, saturation=self.saturation)
        check_positive(bottom_m=self.bottom_m, top_m=self.top_m)
        check_pairs(hue=self.hue, width_m=self.width_m, size_m=self.size_m)


@dataclass(frozen=True)
class ObstacleSettings:
    """Parameters of the obstacle detector."""

    camera: MountingPose  # pose of the camera
    kinds: dict[str, BodySettings]  # what the kinds of bodies look like
    farthest_m: float  # greatest distance at which a body counts [m]
    tracks: TrackSettings  # how tracks begin, move and end

    def __post_init__(self):
        check_positive(farthest_m=self.farthest_m)

    @classmethod
    def read(cls, parameter: Callable[[str], Any]) -> ObstacleSettings:
        """Return the settings of config/obstacle_detector.yaml, see DetectorSettings.read."""
        camera, kinds = MountingPose(**parameter("camera")), {}
        for name, values in parameter("kinds").items():
            try:
                kinds[name] = BodySettings(**values)
            except (TypeError, ValueError) as error:
                raise ValueError(f"kinds/{name}: {error}") from error
        return cls(camera, kinds, parameter("farthest_m"), TrackSettings(**parameter("tracks")))


class SeenBody(NamedTuple):
    """A body in one picture."""

    kind: str  # name of the kind
    x_m: float  # middle of the side that faces the car, ahead of the car's centre [m]
    y_m: float  # the same, to the left [m]
    distance_deviation_m: float  # standard deviation along the line of sight [m]
    width_m: float  # width across the line of sight [m]
    depth_m: float  # size along the line of sight that a body of this kind and width has [m]
    box: tuple[float, float, float, float]  # left, top, right, bottom [px]


class BodyFinder:
    """Finds bodies by colour, lower edge and size."""

    def __init__(self, settings: ObstacleSettings, intrinsic: np.ndarray):
        """Prepare for pictures with the camera matrix K `intrinsic` (3, 3) of camera_info [px]."""
        self._focal_px = float(intrinsic[0][0])
        self._centre_u = float(intrinsic[0][2])
        self._mount = mount = settings.camera
        self._kinds, self._farthest_m = settings.kinds, settings.farthest_m
        self._horizon = float(intrinsic[1][2]) - self._focal_px * math.tan(mount.pitch_rad)
        # The plane in which the coloured part of a body ends.
        self._planes = {
            name: GroundPlane(intrinsic, replace(mount, z_m=mount.z_m - kind.bottom_m))
            for name, kind in self._kinds.items()
        }

    def find(self, image: np.ndarray) -> list[SeenBody]:
        """Return the bodies in a picture (H, W, 3 or 4), BGR first, uint8, the nearest first."""
        # Bodies are about as high as the camera: their lower edge is below the horizon.
        first = max(0, math.floor(self._horizon) - 8)
        lower = image[first:]
        if lower.shape[2] == 4:
            lower = cv2.cvtColor(lower, cv2.COLOR_BGRA2BGR)
        hsv = cv2.cvtColor(lower, cv2.COLOR_BGR2HSV)
        bodies = []
        for name, kind in self._kinds.items():
            mask = colour_mask(hsv, kind.hue, (kind.saturation, 4))
            found: list[SeenBody] = []
            for left, top, part in _parts(mask):
                for column, piece, hidden in _pieces(part, first + top - self._horizon):
                    place = left + column, first + top
                    body = self._body(name, piece, place, image.shape[1], hidden)
                    if body is not None:
                        found.append(body)
            bodies += self._joined(found)
        return sorted(bodies, key=lambda body: body.x_m)

    def _body(
        self, name: str, part: np.ndarray, place: tuple[int, int], columns: int, hidden: bool
    ) -> SeenBody | None:
        """Return the body whose pixels are given, None if it has not the size of one.

        Args:
            name: its kind
            part: (h, w) mask of its pixels
            place: first column and row of the mask in the picture
            columns: width of the picture [px]
            hidden: whether a nearer body of its kind is next to it
        """
        kind, plane = self._kinds[name], self._planes[name]
        left, top = place
        rows = np.flatnonzero(part.any(axis=1))
        upper, lower = top + rows[0] - 0.5 + _WIDER_PX, top + rows[-1] + 0.5 - _WIDER_PX
        right = left + part.shape[1] - 0.5 - _WIDER_PX
        middle = 0.5 * (left - 0.5 + _WIDER_PX + right)
        below = lower - self._horizon
        if below < 1.0:
            return None
        x, y = plane.points(np.array([middle, lower])).tolist()
        depth = x - self._mount.x_m
        if not 0.0 < depth < self._farthest_m:
            return None
        scale = self._focal_px / depth
        width_m = (right - left + 0.5 - _WIDER_PX) / scale
        height_m = (lower - upper) / scale
        whole = left > 0 and left + part.shape[1] < columns
        expected_m = kind.top_m - kind.bottom_m
        if height_m > 1.35 * expected_m + 2.0 / scale or height_m < 0.5 * expected_m - 1.0 / scale:
            return None
        # What is next to a nearer body can be an arm of it.
        least_m = max(kind.width_m[0], _ARM * kind.size_m[1] if hidden else 0.0)
        if width_m > kind.width_m[1] or (whole and width_m < least_m):
            return None
        deviation_m, box = depth * _EDGE_PX / below, (left, upper, right, lower)
        return SeenBody(name, x, y, deviation_m, width_m, self._depth_m(name, width_m), box)

    def _depth_m(self, name: str, width_m: float) -> float:
        """Return the size along the line of sight of a body that is seen with a width [m]."""
        length_m, across_m = self._kinds[name].size_m
        return length_m if width_m < 0.5 * (length_m + across_m) else across_m

    def _joined(self, bodies: list[SeenBody]) -> list[SeenBody]:
        """Return bodies of one kind; two parts of one behind a pole or a trunk are joined."""
        joined: list[SeenBody] = []
        for body in sorted(bodies, key=lambda body: body.box[0]):
            joint = self._both(joined[-1], body) if joined else None
            if joint is None:
                joined.append(body)
            else:
                joined[-1] = joint
        return joined

    def _both(self, first: SeenBody, second: SeenBody) -> SeenBody | None:
        """Return the body of which two are the left and the right part, None if they are two."""
        near, far = (first, second) if first.x_m <= second.x_m else (second, first)
        scale = self._focal_px / (near.x_m - self._mount.x_m)
        left, right = first.box[0], second.box[2]
        gap_m, width_m = (second.box[0] - first.box[2]) / scale, (right - left) / scale
        if (
            not 0.0 < gap_m < _POLE_M
            or far.x_m > _SAME_DISTANCE * near.x_m
            or width_m > _LONGEST * math.hypot(*self._kinds[first.kind].size_m)
        ):
            return None
        top, bottom = min(first.box[1], second.box[1]), max(first.box[3], second.box[3])
        return near._replace(
            y_m=(self._centre_u - 0.5 * (left + right)) / scale,
            width_m=width_m,
            depth_m=self._depth_m(first.kind, width_m),
            box=(left, top, right, bottom),
        )


def covered_boxes(bodies: Sequence[SeenBody]) -> list[tuple[int, int, int, int]]:
    """Return what bodies cover in the picture: left, top, right, bottom [px], wheels included."""
    boxes = []
    for body in bodies:
        left, top, right, bottom = body.box
        aside = _COVERED_ASIDE * (right - left) + 2.0
        below = _COVERED_BELOW * (bottom - top) + 2.0
        first, last = max(0, round(left - aside)), max(0, round(right + aside))
        boxes.append((first, max(0, round(top)), last, max(0, round(bottom + below))))
    return boxes


def _parts(mask: np.ndarray) -> list[tuple[int, int, np.ndarray]]:
    """Return first column, first row and mask of each connected component of a mask (H, W)."""
    left, top, width, height = cv2.boundingRect(mask)
    if not width:
        return []
    # To label the whole picture took more than half of the time. Closing needs two pixels around.
    left, top = max(left - 2, 0), max(top - 2, 0)
    mask = mask[top : top + height + 4, left : left + width + 4]
    mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    parts = []
    for number in range(1, count):
        u, v, width, height, area = stats[number].tolist()
        if area >= _LEAST_PIXELS:
            part = labels[v : v + height, u : u + width] == number
            parts.append((left + u, top + v, part))
    return parts


def _pieces(part: np.ndarray, above_horizon: float) -> list[tuple[int, np.ndarray, bool]]:
    """Split pixels of one colour where the lower edge steps.

    Args:
        part: (h, w) mask of a connected component
        above_horizon: its first row minus the row of the horizon [px]

    Returns:
        first column and mask of each piece, and whether a nearer one is next to it
    """
    height, width = part.shape
    lowest = height - 1 - np.argmax(part[::-1], axis=0) + above_horizon
    # A wheel hides the lower edge: it counts as low as next to the wheel.
    reach = max(1, round(_WHEEL * max(float(lowest.max()), 4.0)))
    kernel = np.ones((1, 2 * reach + 1), np.uint8)
    padded = np.pad(lowest.astype(np.float32), 2 * reach, mode="edge")
    closed = cv2.morphologyEx(padded[None], cv2.MORPH_CLOSE, kernel)[0, 2 * reach : -2 * reach]
    step = np.abs(np.diff(closed)) > np.maximum(_STEP * np.maximum(closed[1:], closed[:-1]), 2.0)
    cuts = [0, *(np.flatnonzero(step) + 1).tolist(), width]
    spans = [(a, b) for a, b in zip(cuts, cuts[1:]) if b - a >= 2]
    lows = [float(np.median(closed[a:b])) for a, b in spans]
    return [
        (a, part[:, a:b], any(low > lows[k] for low in lows[max(k - 1, 0) : k + 2]))
        for k, (a, b) in enumerate(spans)
    ]
