"""Find lane markings in the picture along the normals of predicted lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Tuple

import cv2
import numpy as np

from sdc_perception.ground_plane import GroundPlane
from sdc_perception.marking_filter import ridge
from sdc_perception.vehicle_frame import in_vehicle_frame

Box = Tuple[int, int, int, int]

# Samples of a profile to either side, and of the three boxes of the ridge filter: a marking is
# 0.15 m wide, three of the narrowest samples.
_SIDE = 18
_NARROWEST_M = 0.05
_SAMPLE_PER_PIXEL = 0.4
_GAP = 4
_EDGE_PX = 2.0
# Within so many samples to both sides of paint is asphalt or a kerb, as colourless as paint. Next
# to a kerb is grass. Where samples are farther apart than this, grass is also near paint.
_COLOURLESS = 0.9
_BESIDE = 8
_BESIDE_PAINT_M = 0.065


class View(NamedTuple):
    """A picture, and where it was taken."""

    # (H, W, 4) uint8: blue, green, red, and 0 where a body hides the road, else 255
    image: np.ndarray
    # x [m], y [m] and yaw [rad] of the car in the frame of the odometry
    pose: tuple[float, float, float]
    covered: Sequence[Box] = ()  # left, top, right, bottom of what hides the road [px]

    @classmethod
    def of(
        cls, image: np.ndarray, pose: tuple[float, float, float], covered: Sequence[Box] = ()
    ) -> View:
        """Return a copy of a picture (H, W, 4) BGRA uint8.

        Args:
            image: the picture
            pose: x [m], y [m] and yaw [rad] of the car in the frame of the odometry
            covered: left, top, right, bottom of what hides the road [px]
        """
        copy = image.copy()
        copy[..., 3] = 255
        for left, top, right, bottom in covered:
            copy[top:bottom, left:right, 3] = 0
        return cls(copy, pose, covered)

    def as_earlier(self) -> View:
        """Return the view for later pictures: what a body hides is not known."""
        if not self.covered:
            return self
        image = self.image.copy()
        for left, top, right, bottom in self.covered:
            image[top:bottom, left:right] = 255
        return View(image, self.pose)


@dataclass(frozen=True)
class SearchSettings:
    """What counts as a marking."""

    contrast: float  # least difference to both sides, as a share of the brightness
    contrast_levels: float  # least difference to both sides, 0..255
    whiteness: float  # least share of the darkest colour in the brightness
    coarsest_m: float  # a picture whose pixels are longer on the ground is not searched [m]
    widest_gate_m: float  # greatest distance from the predicted line [m]


class Markings(NamedTuple):
    """Markings that were found."""

    row: np.ndarray  # index (M,) of the profile
    offset_m: np.ndarray  # distances (M,) to the left of the predicted line [m]
    deviation_m: np.ndarray  # standard deviations (M,) [m]


class MarkingSearch:
    """A ridge filter along profiles: brighter than both sides by a marking's width."""

    def __init__(self, ground: GroundPlane, settings: SearchSettings):
        self._ground = ground
        self._settings = settings

    def find(
        self, views: Sequence[View], points_m: np.ndarray, left: np.ndarray, gate_m: np.ndarray
    ) -> tuple[Markings, np.ndarray]:
        """Return the best marking of each profile that has one.

        Args:
            views: the newest picture, and earlier ones
            points_m: predicted points (N, 2) in the frame of the odometry [m]
            left: unit vectors (N, 2) along the profiles
            gate_m: standard deviations (N,) of the prediction [m]

        Returns:
            the markings, and the mask (N,) of the profiles that are in the newest picture and not
            covered
        """
        length_px, inside = self._lengths_px(views[0], points_m, left)
        rows = np.flatnonzero(inside)
        if len(rows) == 0:
            return Markings(rows, np.zeros(0), np.zeros(0)), inside
        pixel_m = 1.0 / length_px[rows]
        spacing = np.maximum(_NARROWEST_M, _SAMPLE_PER_PIXEL * pixel_m)
        across = spacing[:, None] * np.arange(-_SIDE, _SIDE + 1)
        colours = self._colours(views, points_m[rows], left[rows], across)
        profile = cv2.cvtColor(colours, cv2.COLOR_BGRA2GRAY).astype(np.float32)
        blue, green, red, road = (cv2.extractChannel(colours, channel) for channel in range(4))
        darkest = cv2.min(cv2.min(blue, green), cv2.min(red, road)).astype(np.float32)
        return self._peaks(profile, darkest, rows, spacing, pixel_m, gate_m[rows]), inside

    def _lengths_px(
        self, view: View, points_m: np.ndarray, left: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the pixels per metre (N,) along profiles, and the mask (N,) of those in view."""
        ends = np.stack([points_m - 0.1 * left, points_m + 0.1 * left])
        pixels = self._ground.pixels(in_vehicle_frame(ends, view.pose))
        length_px = np.hypot(*np.moveaxis(pixels[1] - pixels[0], -1, 0)) / 0.2
        height, width = view.image.shape[:2]
        middle = 0.5 * (pixels[0] + pixels[1])
        with np.errstate(invalid="ignore"):
            inside = (
                (middle[:, 0] > _EDGE_PX)
                & (middle[:, 0] < width - 1 - _EDGE_PX)
                & (middle[:, 1] > _EDGE_PX)
                & (middle[:, 1] < height - 1 - _EDGE_PX)
                & (length_px * self._settings.coarsest_m > 1.0)
            )
            for left_px, top, right_px, bottom in view.covered:
                u, v = middle.T
                inside &= (u < left_px) | (u >= right_px) | (v < top) | (v >= bottom)
        return length_px, inside

    def _colours(
        self, views: Sequence[View], points_m: np.ndarray, left: np.ndarray, across_m: np.ndarray
    ) -> np.ndarray:
        """Return the darkest colour (N, M, 4) that any view shows at places along profiles.

        Rain is bright, and falls through other places in each picture: where one picture shows a
        drop, another one shows the road.
        """
        darkest: np.ndarray | None = None
        for view in views:
            columns, rows = self._ground.pixels_along(
                in_vehicle_frame(points_m, view.pose),
                in_vehicle_frame(left, (0.0, 0.0, view.pose[2])),
                across_m,
            )
            # Beyond the border, the newest picture is black, and an earlier one does not count.
            beyond = (0.0,) * 4 if darkest is None else (255.0,) * 4
            colours = cv2.remap(
                view.image,
                columns,
                rows,
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_CONSTANT,
                borderValue=beyond,
            )
            darkest = colours if darkest is None else cv2.min(darkest, colours)
        assert darkest is not None
        return darkest

    def _peaks(
        self,
        profile: np.ndarray,
        darkest: np.ndarray,
        rows: np.ndarray,
        spacing: np.ndarray,
        pixel_m: np.ndarray,
        gate_m: np.ndarray,
    ) -> Markings:
        settings = self._settings
        box = profile[:, :-2] + profile[:, 1:-1] + profile[:, 2:]
        box *= np.float32(1.0 / 3.0)
        centre = box[:, _GAP:-_GAP]
        # Along a profile to the left, the box before the centre is on its right.
        brighter = ridge(box[:, 2 * _GAP :], centre, box[:, : -2 * _GAP])
        inner = slice(_GAP + 1, -_GAP - 1)
        brighter[darkest[:, inner] < settings.whiteness * profile[:, inner]] = 0.0
        brighter[self._is_kerb(box, darkest, spacing)] = 0.0
        strength = brighter / np.maximum(centre, 1.0)
        half = brighter.shape[1] // 2
        across = spacing[:, None] * np.arange(-half, half + 1)
        gate = np.minimum(gate_m, settings.widest_gate_m)[:, None]
        score = strength * np.exp(-0.5 * np.square(across / gate)) * (np.abs(across) < 2.5 * gate)
        best = np.clip(np.argmax(score, axis=1), 1, brighter.shape[1] - 2)
        k = np.arange(len(rows))
        peak, before, after = brighter[k, best], brighter[k, best - 1], brighter[k, best + 1]
        share = strength[k, best]
        found = (
            (peak > settings.contrast_levels)
            & (share > settings.contrast)
            & (peak >= before)
            & (peak >= after)
        )
        bend = np.maximum(2.0 * peak - before - after, 1e-3)
        fine = np.clip(0.5 * (after - before) / bend, -0.5, 0.5)
        offset = (best - half + fine) * spacing
        deviation = np.hypot(0.04, 0.5 * pixel_m)
        return Markings(rows[found], offset[found], deviation[found])

    @staticmethod
    def _is_kerb(box: np.ndarray, darkest: np.ndarray, spacing: np.ndarray) -> np.ndarray:
        """Return where the ground next to a place is more coloured than the place (N, M)."""
        colourless = darkest[:, :-2] + darkest[:, 1:-1] + darkest[:, 2:]
        colourless /= 3.0 * np.maximum(box, 1.0)
        beside = cv2.erode(colourless, np.ones((1, 2 * _BESIDE + 1), np.uint8))
        inner = slice(_GAP, -_GAP)
        fine = spacing[:, None] < _BESIDE_PAINT_M
        return fine & (beside[:, inner] < _COLOURLESS * colourless[:, inner])
