"""Measure where the car is in its lane, from the mask of the lane filter, and hold the lane."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from sdc_common.geometry.polyline import Place
from sdc_common.validation import check_positive

_LEAST_PIXELS = 50  # with fewer marked pixels that agree there is no lane
_MOST_PIXELS = 1000  # greatest number of pixels that are used of a picture
_TOLERANCE_M = 0.12  # pixels within this distance of the fitted line agree with it
# The fit begins with the fullest bin of offsets and slopes.
_BIN_M = 0.1
_OFFSETS_M = np.arange(-1.6, 1.5, _BIN_M)
_SLOPES = np.linspace(-0.2, 0.2, 21)[:, None]
_EVERY = 2  # every second pixel is counted in the bins
_MOST_FITS = 5  # number of fits, each to the pixels that agree with the fit before
_GAIN = 0.3  # share of the measured offset by which a picture moves the path
_KEPT_TICKS = 60  # ticks whose places wait for their pictures


@dataclass(frozen=True)
class LaneFit:
    """Projects marked pixels onto the flat road, and fits a parabola to both lines of the lane.

    The fields are those of config/camera.yaml. The picture is 90 degrees wide.
    """

    camera_x_m: float
    camera_z_m: float
    camera_pitch_rad: float
    near_m: float
    far_m: float
    lane_width_m: float
    steepest: float

    def __post_init__(self):
        check_positive(camera_z_m=self.camera_z_m, lane_width_m=self.lane_width_m)
        check_positive(steepest=self.steepest, length_m=self.far_m - self.near_m)

    def measure(self, mask: np.ndarray) -> float | None:
        """Return how far the car is left of the middle of its lane [m], None if it sees no lane."""
        x, y = self._ground_points(mask)
        # A pixel is on the right or on the left line, from which the car's offset follows.
        half_m = self.lane_width_m / 2.0
        x, offset = np.hstack([x, x]), np.hstack([-half_m - y, half_m - y])
        # Pixels of the lines agree about the offset: the fit begins with the fullest bin.
        few = (offset[::_EVERY] - _OFFSETS_M[0]) / _BIN_M + 1.0 - _SLOPES / _BIN_M * x[::_EVERY]
        bins = np.clip(few, 0.0, len(_OFFSETS_M) + 1.0).astype(np.int32)
        bins += (len(_OFFSETS_M) + 2) * np.arange(len(_SLOPES), dtype=np.int32)[:, None]
        counts = np.bincount(bins.ravel(), minlength=len(_SLOPES) * (len(_OFFSETS_M) + 2))
        inside = counts.reshape(len(_SLOPES), -1)[:, 1:-1]
        slope, place = divmod(int(inside.argmax()), len(_OFFSETS_M))
        middle_m = _OFFSETS_M[place] + _BIN_M / 2.0
        agree = np.abs(offset - middle_m - _SLOPES[slope] * x) < 2.0 * _TOLERANCE_M
        powers = np.column_stack([np.ones_like(x), x, x * x])
        for _ in range(_MOST_FITS):
            if np.count_nonzero(agree) < _LEAST_PIXELS:
                return None
            rows = powers[agree]
            curve = np.linalg.lstsq(rows.T @ rows, rows.T @ offset[agree], rcond=None)[0]
            agree = np.abs(offset - powers @ curve) < _TOLERANCE_M
        return float(curve[0]) if abs(curve[1]) < self.steepest else None

    def _ground_points(self, mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return x (ahead) and y (left) of marked pixels on the road [m]."""
        height, width = mask.shape
        c, s = math.cos(self.camera_pitch_rad), math.sin(self.camera_pitch_rad)
        below = (np.arange(height) - height / 2.0) * 2.0 / width
        down, ahead = np.maximum(c * below + s, 1e-6), c - s * below
        x = self.camera_x_m + self.camera_z_m * ahead / down
        seen = np.flatnonzero((self.near_m < x) & (x < self.far_m))
        found = cv2.findNonZero(mask[seen[0] : seen[-1] + 1]) if len(seen) else None
        if found is None:
            return np.empty(0), np.empty(0)
        every = np.linspace(0, len(found) - 1, min(len(found), _MOST_PIXELS)).astype(int)
        columns, rows = found[every].reshape(-1, 2).T  # OpenCV 5 returns rows, OpenCV 4 one column
        y = self.camera_z_m * (1.0 - columns * 2.0 / width) / down[seen[rows]]
        return x[seen[rows]], y


class LaneHold:
    """Moves the path to where the camera sees the lane: the position of the car may be wrong."""

    def __init__(self):
        self._cross_track_m: dict = {}
        self._shift_m = 0.0

    def see(self, stamp: Any, offset_m: float) -> None:
        """Take the offset in the lane that the camera has measured at a stamp [m]."""
        if stamp in self._cross_track_m and math.isfinite(offset_m):
            self._shift_m += _GAIN * (self._cross_track_m[stamp] - offset_m - self._shift_m)

    def moved(self, rows: np.ndarray, stamp: Any, place: Place) -> np.ndarray:
        """Return the rows x, y, v of a path, moved; the car seems to be at `place`."""
        self._cross_track_m[stamp] = place.cross_track_m
        if len(self._cross_track_m) > _KEPT_TICKS:
            del self._cross_track_m[next(iter(self._cross_track_m))]
        along = np.gradient(rows[:, :2], axis=0)
        left = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
        return np.column_stack([rows[:, :2] + self._shift_m * left, rows[:, 2]])
